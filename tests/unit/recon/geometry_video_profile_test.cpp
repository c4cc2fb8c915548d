#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.h"
#include "recon/video/geometry_picture.h"
#include "recon/video/geometry_video.h"
#include "recon/video/paper_video.h"
#include "tests/unit/recon/geometry_video_files.h"

namespace rotunda::recon {
namespace {

using test::largest_distance;
using test::travelling_ball;
using test::write;

using GeometryVideoProfile = test::GeometryVideoTest;

TEST_F(GeometryVideoProfile, OfProfileMasterWithAMeanIsAsTrueAndSmaller) {
  const auto images = travelling_ball(12, 6);
  write_geometry_video(folder_ / "without.mkv", images);
  for (const char* name : {"with.mkv", "with.avi"}) {
    write(folder_ / name, images, VideoProfile::master);
    EXPECT_LT(std::filesystem::file_size(folder_ / name), std::filesystem::file_size(folder_ / "without.mkv")) << name;
    GeometryVideoReader reader(folder_ / name);
    EXPECT_EQ(reader.header().version, 4);
    for (const int frame : {11, 0, 5}) {  // half a step of 0.039 mm along each axis
      EXPECT_LT(largest_distance(reader.read(frame), images[static_cast<std::size_t>(frame)]), 3.6e-5F) << name;
      EXPECT_EQ(reader.read(frame).colours, images[static_cast<std::size_t>(frame)].colours);
    }
  }
}

TEST_F(GeometryVideoProfile, AsAviLiesBesideItsHeader) {
  const auto images = travelling_ball(3, 4);
  const auto avi = folder_ / "geometry.avi";
  write(avi, images, VideoProfile::float32);
  EXPECT_LT(largest_distance(GeometryVideoReader(avi).read(2), images[2]), 5e-7F);
  write(avi, images, VideoProfile::master);
  std::filesystem::remove(folder_ / "geometry.mean.png");
  EXPECT_THROW(GeometryVideoReader{avi}, std::system_error);
  std::filesystem::remove(folder_ / "geometry.json");
  EXPECT_THROW(GeometryVideoReader{avi}, std::system_error);
  EXPECT_THROW(write(folder_ / "stream.avi", travelling_ball(2, 6), VideoProfile::stream), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "stream.avi"));
}

TEST_F(GeometryVideoProfile, ReadForDrawingIsTheSameWithoutNormalsAndCoverage) {
  const auto images = travelling_ball(5, 6);
  for (const auto profile : {VideoProfile::master, VideoProfile::stream}) {
    write(file_, images, profile);
    GeometryVideoReader whole(file_), drawn(file_);
    for (const int frame : {0, 1, 4, 2}) {
      const auto expected = whole.read(frame);
      const auto image = drawn.read(frame, {.drawn = true});
      EXPECT_EQ(image.positions, expected.positions);
      EXPECT_EQ(image.colours, expected.colours);
      EXPECT_TRUE(image.normals.empty() && image.coverage.empty());
      EXPECT_EQ(drawn.read(frame).coverage, expected.coverage) << frame;  // what was left out comes back whole
    }
    const auto coarse = drawn.read(3, {.level = 4, .in_place = true, .drawn = true});
    EXPECT_EQ(coarse.positions, whole.read_in_place(3, 4).positions);
  }
}

TEST_F(GeometryVideoProfile, BetweenFramesIsTheirBlendWhereSamplesCorrespond) {
  const auto images = travelling_ball(4, 4);
  write(file_, images, VideoProfile::master, /*aligned=*/true);
  GeometryVideoReader reader(file_);
  const auto between = reader.read_between(1.25, 4);
  for (std::size_t v = 0; v < between.positions.size(); ++v) {
    const Eigen::Vector3f expected = 0.75F * images[1].positions[v] + 0.25F * images[2].positions[v];
    ASSERT_LT((between.positions[v] - expected).norm(), 5e-5F);
    ASSERT_NEAR(between.normals[v].norm(), 1.0F, 1e-5F);
  }
  EXPECT_EQ(between.colours[7][0], 1);  // 1 and 2, a quarter of the way
  EXPECT_EQ(reader.read_between(2.0, 4).positions, reader.read(2).positions);
  EXPECT_THROW(reader.read_between(3.5, 4), InvalidInput);
  EXPECT_THROW(reader.read_between(-0.5, 4), InvalidInput);
  write(file_, images, VideoProfile::master, /*aligned=*/false);
  GeometryVideoReader apart(file_);
  EXPECT_EQ(apart.read_between(1.25, 4).positions, apart.read(1).positions);
}

TEST_F(GeometryVideoProfile, OfProfileFloatKeepsWhatFloatsHold) {
  const auto images = travelling_ball(4);
  write(file_, images, VideoProfile::float32);
  GeometryVideoReader reader(file_);
  EXPECT_EQ(reader.header().profile, VideoProfile::float32);
  for (const int frame : {3, 0, 1}) {
    const auto& expected = images[static_cast<std::size_t>(frame)];
    EXPECT_LT(largest_distance(reader.read(frame), expected), 5e-7F)
        << frame;  // the root's share of a float's last bit
    EXPECT_EQ(reader.read(frame).colours, expected.colours);
  }
  EXPECT_EQ(reader.read(2, 4).positions.size(), 17U * 17U);
}

TEST_F(GeometryVideoProfile, OfProfileStreamIsSmallerAndCloseWhicheverFrameComesFirst) {
  const auto images = travelling_ball(30, 6);  // more than from key frame to key frame
  write(file_, images, VideoProfile::stream);
  write(folder_ / "master.mkv", images, VideoProfile::float32);
  EXPECT_LT(std::filesystem::file_size(file_), std::filesystem::file_size(folder_ / "master.mkv") / 4);
  GeometryVideoReader reader(file_);
  for (const int frame : {29, 0, 1, 27, 24, 25, 12}) {
    const auto& expected = images[static_cast<std::size_t>(frame)];
    const auto image = reader.read(frame);
    EXPECT_LT(largest_distance(image, expected), 2e-3F) << frame;
    EXPECT_EQ(image.coverage, expected.coverage);
    double error = 0.0;
    for (std::size_t i = 0; i < image.colours.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) error += std::abs(int{image.colours[i][c]} - int{expected.colours[i][c]});
    EXPECT_LT(error / static_cast<double>(3 * image.colours.size()), 4.0) << frame;  // of 255 levels
  }
}

TEST_F(GeometryVideoProfile, PaperModeComesBackToHalfALevel) {
  const auto images = travelling_ball(4);
  const auto json = folder_ / "geometry.json", avi = folder_ / "geometry.avi";
  write_paper_video(avi, json, images);
  PaperVideoReader reader(avi, json);
  for (const int frame : {0, 3, 1}) {
    const auto& expected = images[static_cast<std::size_t>(frame)];
    const GeometryImage image = reader.read(frame);
    const std::size_t side = 33;
    for (std::size_t row = 1; row + 1 < side; ++row)
      for (std::size_t column = 1; column + 1 < side; ++column) {
        const std::size_t i = row * side + column;
        const Eigen::Vector3f error = (image.positions[i] - expected.positions[i]).cwiseAbs();
        EXPECT_LE(error.maxCoeff(), 0.00501F);
        EXPECT_EQ(image.colours[i], expected.colours[row * 2 * 65 + column * 2]);
      }
    for (std::size_t i = 0; i < side; ++i) EXPECT_EQ(image.positions[i], image.positions[side - 1 - i]);
  }
}

TEST_F(GeometryVideoProfile, PicturesShowPositionsAndColours) {
  const auto image = test::round_geometry_image();
  const cv::Mat positions = position_picture(image), colours = colour_picture(image);
  ASSERT_EQ(positions.size(), cv::Size(33, 33));
  ASSERT_EQ(colours.size(), cv::Size(65, 65));
  EXPECT_EQ(positions.at<cv::Vec3b>(16, 16)[2], 255);  // the pole +z at the centre
  EXPECT_EQ(positions.at<cv::Vec3b>(0, 0)[2], 0);      // -z at the corners
  EXPECT_EQ(colours.at<cv::Vec3b>(32, 64)[0], 255);    // +x at the right
}

}  // namespace
}  // namespace rotunda::recon
