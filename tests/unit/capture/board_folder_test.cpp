#include "capture/calibration/board_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

fs::path fresh_folder() {
  const auto folder = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::remove_all(folder);
  fs::create_directories(folder / "cam00");
  fs::create_directories(folder / "cam01");
  return folder;
}

TEST(BoardFolder, FilesOfOneNameAreOneMomentInTheOrderOfTheirNumbers) {
  const auto folder = fresh_folder();
  const cv::Mat grey(8, 10, CV_8UC1, cv::Scalar(77)), colour(8, 10, CV_8UC3, cv::Scalar(10, 99, 30)),
      deep(8, 10, CV_16UC1, cv::Scalar(40000));
  cv::imwrite(folder / "cam00/shot10.png", grey);
  cv::imwrite(folder / "cam00/shot2.png", deep);
  cv::imwrite(folder / "cam01/shot2.png", colour);
  std::ofstream(folder / "cam01/notes.txt") << "no picture";
  const auto read = read_board_folder(folder);
  EXPECT_THAT(read.pictures.cameras, ElementsAre("cam00", "cam01"));
  EXPECT_THAT(read.pictures.moments, ElementsAre("shot2", "shot10"));
  EXPECT_TRUE(read.skipped.empty());
  EXPECT_EQ(read.pictures.grey(0, 0).type(), CV_16UC1);
  EXPECT_EQ(read.pictures.grey(0, 0).at<std::uint16_t>(3, 3), 40000);
  EXPECT_EQ(read.pictures.grey(1, 0).at<std::uint8_t>(3, 3), 99);  // green
  EXPECT_TRUE(read.pictures.grey(1, 1).empty());
}

TEST(BoardFolder, NamesWhatCannotBeRead) {
  const auto folder = fresh_folder();
  const cv::Mat grey(64, 64, CV_8UC1, cv::Scalar(77));
  cv::imwrite(folder / "cam00/a.jpg", grey);
  cv::imwrite(folder / "cam01/a.jpg", grey);
  fs::resize_file(folder / "cam01/a.jpg", fs::file_size(folder / "cam01/a.jpg") / 2);
  std::ofstream(folder / "cam00/b.png");
  std::ofstream(folder / "cam01/b.png") << "not a PNG at all, IEND or not";
  const auto read = read_board_folder(folder);
  EXPECT_EQ(read.skipped.size(), 3U);
  EXPECT_THAT(read.skipped, Contains(AllOf(HasSubstr("cam01/a.jpg"), HasSubstr("cut short"))));
  EXPECT_THAT(read.skipped, Contains(AllOf(HasSubstr("cam00/b.png"), HasSubstr("empty"))));
  EXPECT_THAT(read.skipped, Contains(AllOf(HasSubstr("cam01/b.png"), HasSubstr("no picture"))));
  EXPECT_FALSE(read.pictures.grey(0, 0).empty());
  fs::create_directories(folder / "cam02");
  EXPECT_THAT(read_board_folder(folder).skipped, Contains(AllOf(HasSubstr("cam02"), HasSubstr("no pictures"))));
  EXPECT_THROW(read_board_folder(folder / "nothing"), InvalidInput);
  fs::create_directories(folder / "empty/cam00");
  EXPECT_THROW(read_board_folder(folder / "empty"), InvalidInput);
}

// OpenCV would fill such a picture's damaged part with grey; what a program adds behind a picture is no damage.
TEST(BoardFolder, NamesADamagedJpegAndReadsOneWithMoreBehindIt) {
  const auto folder = fresh_folder();
  cv::Mat picture(240, 320, CV_8UC3);
  cv::randu(picture, 0, 255);
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg);
  const auto write = [&](const char* name) {
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  };
  write("cam00/a.jpg");
  jpeg.insert(jpeg.end(), {'m', 'o', 'r', 'e'});
  write("cam00/b.jpg");
  for (std::size_t i = 1000; i < jpeg.size() / 2; i += 37) jpeg[i] ^= 0x5aU;
  write("cam01/a.jpg");
  const auto read = read_board_folder(folder);
  EXPECT_THAT(read.skipped, testing::ElementsAre(AllOf(HasSubstr("cam01/a.jpg"), HasSubstr("damaged JPEG"))));
  EXPECT_FALSE(read.pictures.grey(0, 1).empty());
}

TEST(BoardFolder, ReadsProgressiveAndGreyJpegs) {
  const auto folder = fresh_folder();
  cv::Mat picture(120, 160, CV_8UC3);
  cv::randu(picture, 0, 255);
  cv::imwrite(folder / "cam00/a.jpg", picture, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  cv::extractChannel(picture, picture, 1);
  cv::imwrite(folder / "cam01/b.jpg", picture);
  const auto read = read_board_folder(folder);
  EXPECT_THAT(read.skipped, testing::IsEmpty());
  EXPECT_EQ(read.pictures.moments.size(), 2U);
}

}  // namespace
}  // namespace rotunda::capture
