#include "capture/calibration/board_video.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kRate = 10, kWidth = 160, kHeight = 120;

// Where the board is at each frame: it stands for a second at four places and needs half a second between.
int place_at(int frame) {
  const int stretch = frame / 15, within = frame % 15;
  return 20 + 30 * stretch + (within < 10 ? 0 : 5 * (within - 9));
}

class BoardVideoTest : public testing::Test {
 protected:
  // A bright square on noise, by the ffmpeg program.
  fs::path write_video(const std::string& name, int frames, int rate = kRate, bool moving = true) {
    const auto pictures = folder_.path() / (name + ".frames");
    fs::create_directories(pictures);
    cv::RNG random(7);
    for (int frame = 0; frame < frames; ++frame) {
      cv::Mat picture(kHeight, kWidth, CV_8UC3);
      random.fill(picture, cv::RNG::NORMAL, 60, 2);
      cv::rectangle(picture, {moving ? place_at(frame) : 20, 40, 30, 30}, cv::Scalar(230, 220, 210), cv::FILLED);
      cv::imwrite((pictures / fmt::format("{:04}.png", frame)).string(), picture);
    }
    const auto file = videos() / name;
    fs::create_directories(videos());
    const auto command = fmt::format("ffmpeg -v error -y -framerate {} -i {}/%04d.png -c:v mpeg4 -q:v 2 {}", rate,
                                     pictures.string(), file.string());
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return file;
  }
  fs::path videos() const { return folder_.path() / "videos"; }
  fs::path out() const { return folder_.path() / "out"; }

  test::TemporaryFolder folder_;
};

TEST_F(BoardVideoTest, EveryPlaceWhereTheBoardStandsIsKeptAndNoneWhereItMoves) {
  write_video("cam00.mp4", 60);
  write_video("cam01.avi", 60);
  const auto found = videos_in(videos());
  ASSERT_EQ(found.size(), 2U);
  const auto stills = write_board_stills(found, out());
  EXPECT_TRUE(stills.troubles.empty());
  std::set<int> places;
  for (const auto frame : stills.frames) {
    const int within = static_cast<int>(frame) % 15;
    EXPECT_LT(within, 10) << "frame " << frame << " is of a moving board";
    places.insert(static_cast<int>(frame) / 15);
    for (const auto* camera : {"cam00", "cam01"}) {
      const cv::Mat rgb = read_rgb(out() / camera / fmt::format("frame{:06}.png", frame));
      ASSERT_EQ(rgb.size(), cv::Size(kWidth, kHeight));
      EXPECT_NEAR(rgb.at<cv::Vec3b>(55, place_at(static_cast<int>(frame)) + 15)[0], 210, 6) << "red, and this frame";
    }
  }
  EXPECT_EQ(places, (std::set<int>{0, 1, 2, 3}));
  EXPECT_EQ(stills.frames.size(), 4U) << "each place once";
}

TEST_F(BoardVideoTest, OfABoardThatNeverMovesOneMomentIsKept) {
  write_video("cam00.mp4", 30, kRate, false);
  EXPECT_EQ(write_board_stills(videos_in(videos()), out()).frames.size(), 1U);
}

TEST_F(BoardVideoTest, VideosThatCannotShowTheSameMomentsAreRefusedByName) {
  write_video("cam00.mp4", 20);
  write_video("cam01.mp4", 20, 15);
  try {
    write_board_stills(videos_in(videos()), out());
    FAIL() << "rates differ";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("cam00.mp4 has 10"), HasSubstr("cam01.mp4 has 15")));
  }
  fs::copy_file(videos() / "cam00.mp4", videos() / "cam00.mov");
  EXPECT_THROW(videos_in(videos()), InvalidInput);
}

TEST_F(BoardVideoTest, ADamagedOneIsToldOrRefused) {
  const auto file = write_video("cam00.avi", 40);
  fs::resize_file(file, fs::file_size(file) / 2);
  const auto stills = write_board_stills(videos_in(videos()), out());
  EXPECT_FALSE(stills.frames.empty());
  std::ofstream(file) << "no video";
  EXPECT_THROW(write_board_stills(videos_in(videos()), out()), CorruptData);
  fs::remove(file);
  EXPECT_TRUE(videos_in(videos()).empty());
}

}  // namespace
}  // namespace rotunda::capture
