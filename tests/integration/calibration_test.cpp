// rotunda calibrate on pictures with everything wrong that pictures have.
#include <fmt/format.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "capture/picture.h"
#include "simulator/people/board_prop.h"
#include "tests/integration/house_test.h"
#include "tests/support/board_scene.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Pictures of a board on disk, with everything wrong that pictures on disk have.
class CalibrationOfPictures : public HouseTest {
 protected:
  static constexpr int kWidth = 432, kHeight = 344;
  CalibrationOfPictures() {
    simulator::write_board(board_, {.columns = 6, .rows = 4, .square = 0.18, .marker = 0.144});
    const capture::BoardPrint print(capture::read_boards(board_).front());
    const auto rig = board_rig(6, kWidth, kHeight, 450.0);
    const Eigen::Vector3d between = (rig[0].centre() + rig[1].centre()).normalized();  // 60 degrees apart
    for (const auto& pose : board_walk(80))
      if (pose.linear().col(2).dot(between) > 0.75 && moments_ < 9) {
        for (std::size_t i = 0; i < 2; ++i)
          write(rig[i].name, moments_, board_picture(rig[i], print, pose, {.noise = 1.0}));
        ++moments_;
      }
  }
  void write(const std::string& camera, int moment, const cv::Mat& picture) {
    fs::create_directories(images_ / camera);
    capture::write_png(picture_file(camera, moment), picture);
  }
  fs::path picture_file(const std::string& camera, int moment) const {
    return images_ / camera / fmt::format("m{}.png", moment);
  }
  Outcome calibrate(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"calibrate",     "--images", images_.string(), "--board",
                                       board_.string(), "-o",       out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return rotunda(arguments);
  }

  const fs::path images_ = folder() / "images", board_ = folder() / "board.yaml", out_ = folder() / "found.yaml";
  int moments_ = 0;
};

TEST_F(CalibrationOfPictures, WhatCannotBeReadIsNamedAndTheRestIsUsed) {
  const cv::Mat grey = capture::read_grey(picture_file("cam00", 0));
  cv::Mat deep, colour;
  grey.convertTo(deep, CV_16U, 257.0);
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2RGB);
  write("cam00", 0, deep);                                         // 16 bits: read
  write("cam00", 1, capture::read_rgb(picture_file("cam00", 1)));  // colour where grey was meant: read
  std::ofstream(images_ / "cam00" / "zero.png");
  cv::imwrite((images_ / "cam01" / "cut.jpg").string(), colour);
  fs::resize_file(images_ / "cam01" / "cut.jpg", fs::file_size(images_ / "cam01" / "cut.jpg") / 2);
  write("cam01", 90, cv::Mat(50, 60, CV_8UC1, cv::Scalar(7)));  // of another size
  const auto outcome = calibrate({"--force", "--json"});        // nine boards are too few to be trusted
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("zero.png"), HasSubstr("is empty"), HasSubstr("cut.jpg"), HasSubstr("cut short")));
  EXPECT_THAT(outcome.err, Not(HasSubstr("m0.png")));
  const auto told = json::parse(outcome.out);
  EXPECT_THAT(told["problems"].dump(), AllOf(HasSubstr("m90"), HasSubstr("60 x 50")));
  EXPECT_GE(told["cameras"][0]["views"], 7) << "the 16-bit and the colour picture are two of them";
  const auto written = text_of(out_);
  const auto again = calibrate();
  EXPECT_EQ(again.exit_code, 3);
  EXPECT_THAT(again.err, HasSubstr("found.yaml exists already"));
  EXPECT_EQ(text_of(out_), written);
}

TEST_F(CalibrationOfPictures, TooLittleIsRefusedAndNothingWritten) {
  const auto refused = [&](const std::string& why) {
    const auto outcome = calibrate({"--force"});
    EXPECT_EQ(outcome.exit_code, 3) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_FALSE(fs::exists(out_));
  };
  for (int moment = 2; moment < moments_; ++moment)
    for (const auto* camera : {"cam00", "cam01"}) fs::remove(picture_file(camera, moment));
  const auto doubted = calibrate({});
  EXPECT_EQ(doubted.exit_code, 3) << doubted.err;
  EXPECT_THAT(doubted.out, HasSubstr("no camera saw the board more than twice")) << doubted.err;
  EXPECT_FALSE(fs::exists(out_));
  for (int moment = 2; moment < moments_; ++moment)
    for (const auto* camera : {"cam00", "cam01"})
      write(camera, moment, cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(99)));
  for (const auto* camera : {"cam00", "cam01"})
    for (int moment = 0; moment < 2; ++moment)
      fs::copy_file(picture_file(camera, 3), picture_file(camera, moment), fs::copy_options::overwrite_existing);
  refused("neither markers nor a chessboard are to be recognised");
  fs::remove_all(images_ / "cam01");
  refused("there is 1 camera");
  fs::remove_all(images_ / "cam00");
  refused("holds no pictures");
}

}  // namespace
}  // namespace rotunda::tests
