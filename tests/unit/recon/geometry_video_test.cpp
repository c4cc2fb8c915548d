#include "recon/video/geometry_video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.h"
#include "tests/unit/recon/geometry_video_files.h"

namespace rotunda::recon {
namespace {

using test::largest_distance;
using test::travelling_ball;
using ::testing::HasSubstr;

using GeometryVideo = test::GeometryVideoTest;

TEST_F(GeometryVideo, ComesBackInTheWorldToOneStepOfSixteenBits) {
  const auto images = travelling_ball(7);
  write_geometry_video(file_, images);
  GeometryVideoReader reader(file_);
  ASSERT_EQ(reader.frame_count(), 7);
  for (const int frame : {0, 1, 2, 6, 3, 3, 0}) {
    const auto& expected = images[static_cast<std::size_t>(frame)];
    const GeometryImage image = reader.read(frame);
    EXPECT_LT(largest_distance(image, expected), 2e-5F) << frame;  // 1.2 m / 65535 / 2 on each of three axes
    EXPECT_EQ(image.colours, expected.colours) << frame;
    EXPECT_EQ(image.coverage, expected.coverage) << frame;
  }
}

TEST_F(GeometryVideo, KeepsTheRootApart) {
  const auto images = travelling_ball(5);
  write_geometry_video(file_, images);
  GeometryVideoReader reader(file_);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(reader.header().root_path[static_cast<std::size_t>(i)].x(), 0.8 * i - 2.0, 1e-3);
    EXPECT_LT(root_of(reader.read_in_place(i, 5)).norm(), 1e-3);
  }
  // The box holds the body, not its way across the stage.
  EXPECT_LT(reader.header().box.sizes().x(), 1.3);
}

TEST_F(GeometryVideo, HeaderKeepsStatusesRateAndFirstFrame) {
  const auto images = travelling_ball(3, 3);
  GeometryVideoHeader header;
  header.fps = 30000.0 / 1001.0;
  header.first_frame = 120;
  add_frame(header, images[0]);
  add_frame(header, images[1], {.interpolated = true, .reason = "two flipped triangles \xff"});
  add_frame(header, images[2]);
  GeometryVideoWriter writer(file_, header);
  for (const auto& image : images) writer.write(image);
  writer.finish();
  GeometryVideoReader reader(file_);
  EXPECT_DOUBLE_EQ(reader.header().fps, header.fps);
  EXPECT_EQ(reader.header().first_frame, 120);
  EXPECT_FALSE(reader.header().statuses[0].interpolated);
  EXPECT_TRUE(reader.header().statuses[1].interpolated);
  EXPECT_THAT(reader.header().statuses[1].reason, HasSubstr("two flipped triangles"));
  EXPECT_LT(largest_distance(reader.read(2), images[2]), 2e-5F);
}

TEST_F(GeometryVideo, CoarserLevelsAreEverySecondSample) {
  const auto images = travelling_ball(1);
  write_geometry_video(file_, images);
  GeometryVideoReader reader(file_);
  const GeometryImage fine = reader.read(0), coarse = reader.read(0, 3);
  ASSERT_EQ(coarse.side(), 9);
  for (int row = 0; row < 9; ++row)
    for (int column = 0; column < 9; ++column)
      EXPECT_EQ(coarse.positions[static_cast<std::size_t>(row * 9 + column)],
                fine.positions[static_cast<std::size_t>(row * 4 * 33 + column * 4)]);
  EXPECT_EQ(coarse.colours.size(), fine.colours.size());
  EXPECT_THROW(reader.read(0, 6), InvalidInput);
  EXPECT_THROW(reader.read(0, 0), InvalidInput);
  EXPECT_THROW(reader.read(1), InvalidInput);
  EXPECT_THROW(reader.read(-1), InvalidInput);
}

TEST_F(GeometryVideo, EveryLevelRoundTrips) {
  for (int level = 1; level <= 7; ++level) {
    const auto images = travelling_ball(2, level);
    write_geometry_video(file_, images);
    EXPECT_LT(largest_distance(GeometryVideoReader(file_).read(1), images[1]), 2e-5F) << level;
  }
}

TEST_F(GeometryVideo, NormalsOfABallPointAwayFromItsCentreAlsoOnTheBorder) {
  const auto image = test::round_geometry_image({.level = 6});
  for (std::size_t i = 0; i < image.normals.size(); ++i) {
    const Eigen::Vector3f outwards = (image.positions[i] - Eigen::Vector3f(0.3F, -0.2F, 1.0F)).normalized();
    EXPECT_GT(image.normals[i].dot(outwards), 0.997F) << i;  // 4 degrees: the octahedron's corners are uneven
  }
  const std::size_t side = 65;
  for (std::size_t i = 0; i < side; ++i) EXPECT_EQ(image.normals[i], image.normals[side - 1 - i]);
}

TEST_F(GeometryVideo, LeavesNothingWhenAbandoned) {
  const auto images = travelling_ball(3, 3);
  GeometryVideoHeader header;
  for (const auto& image : images) add_frame(header, image);
  {
    GeometryVideoWriter writer(file_, header);
    writer.write(images[0]);
    EXPECT_THROW(writer.finish(), InvalidInput);  // two frames are missing
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(GeometryVideo, RefusesFramesThatDoNotFitTheHeader) {
  auto images = travelling_ball(2, 3);
  GeometryVideoHeader header;
  add_frame(header, images[0]);
  EXPECT_THROW(add_frame(header, travelling_ball(1, 4)[0]), InvalidInput);
  GeometryVideoWriter writer(file_, header);
  EXPECT_THROW(writer.write(travelling_ball(1, 4)[0]), InvalidInput);
  images[0].positions[5].y() += 3.0F;
  EXPECT_THROW(writer.write(images[0]), InvalidInput);
  images[0].positions[5].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(writer.write(images[0]), InvalidInput);
  EXPECT_THROW(add_frame(header, images[0]), InvalidInput);
  EXPECT_THROW(GeometryVideoWriter(folder_ / "no" / "where.mkv", header), std::system_error);
}

TEST_F(GeometryVideo, RefusesColoursTheHeaderWasNotToldOf) {
  auto images = travelling_ball(2);
  GeometryVideoHeader header;
  MeanSurface mean;
  for (const auto& image : images) {
    add_frame(header, image);
    mean.add(image.positions, header.root_path.back());
  }
  GeometryVideoWriter writer(file_, header, mean);
  writer.write(images[0]);
  images[1].colours[3][1] ^= 1;
  EXPECT_THROW(writer.write(images[1]), InvalidInput);
}

TEST_F(GeometryVideo, RefusesAbsurdHeaders) {
  const auto images = travelling_ball(1, 3);
  GeometryVideoHeader header;
  add_frame(header, images[0]);
  const std::string good = to_json(header);
  EXPECT_NO_THROW(header_from_json(good));
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& says) {
    std::string bad = good;
    const auto at = bad.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    bad.replace(at, from.size(), to);
    try {
      header_from_json(bad);
      ADD_FAILURE() << to << " was accepted";
    } catch (const CorruptData& error) {
      EXPECT_THAT(error.what(), HasSubstr(says)) << to;
    }
  };
  refused("\"version\": 1", "\"version\": 5", "version 5");
  refused("\"version\": 1", "\"version\": 3", "difference_box");
  refused("\"version\": 1", "\"version\": 2", "profile");
  refused("\"version\": 1", "\"version\": 2, \"profile\": \"odd\"", "odd");
  refused("\"version\": 1", "\"version\": 2, \"profile\": \"stream\"", "difference_box");
  refused("\"level\": 3", "\"level\": -1", "level is -1");
  refused("\"level\": 3", "\"level\": 13", "level is 13");
  refused("\"level\": 3", "\"level\": 9999999999", "level is 9999999999");
  refused("\"colour_level\": 4", "\"colour_level\": 2", "coarser");
  refused("\"fps\": 25.0", "\"fps\": 0", "rate");
  refused("\"fps\": 25.0", "\"fps\": -25", "rate");
  refused("\"status\": \"mapped\"", "\"status\": \"lost\"", "lost");
  refused("\"unit\": \"m\"", "\"unit\": \"inch\"", "unit");
  refused("\"min\"", "\"low\"", "min");
  refused("\"max\": [", "\"max\": [null, ", "number");
  refused("\"max\": [", "\"max\": [-9, ", "inside out");
  refused("\"max\": [", "\"max\": [1e9, ", "no place");
  refused("rotunda geometry video", "something else", "no geometry video");
  EXPECT_THROW(header_from_json(""), CorruptData);
  EXPECT_THROW(header_from_json("[]"), CorruptData);
}

}  // namespace
}  // namespace rotunda::recon
