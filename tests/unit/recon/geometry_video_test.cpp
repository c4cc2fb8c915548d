#include "recon/video/geometry_video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "config/errors.h"
#include "recon/video/geometry_picture.h"
#include "recon/video/lattice_normals.h"
#include "recon/video/paper_video.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::recon {
namespace {

using ::testing::HasSubstr;

class GeometryVideo : public ::testing::Test {
 protected:
  GeometryVideo() { std::filesystem::create_directories(folder_); }
  ~GeometryVideo() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("rotunda_geometry_video_" + std::to_string(::getpid()));
  std::filesystem::path file_ = folder_ / "geometry.mkv";
};

// A ball that travels four metres and breathes, so that every frame differs.
std::vector<GeometryImage> travelling_ball(int frames, int level = 5) {
  std::vector<GeometryImage> images;
  for (int i = 0; i < frames; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(frames);
    images.push_back(test::round_geometry_image({.level = level,
                                                 .colour_level = level + 1,
                                                 .centre = {4.0F * t - 2.0F, 0.3F, 1.0F},
                                                 .radii = {0.5F + 0.1F * t, 0.4F, 0.6F}}));
    images.back().colours[7] = {static_cast<std::uint8_t>(i), 1, 2};
  }
  return images;
}

float largest_distance(const GeometryImage& a, const GeometryImage& b) {
  float distance = 0.0F;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    distance = std::max(distance, (a.positions[i] - b.positions[i]).norm());
  return distance;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

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
  refused("\"version\": 1", "\"version\": 4", "version 4");
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

TEST_F(GeometryVideo, CutShortKeepsTheFramesBeforeTheCut) {
  const auto images = travelling_ball(10, 4);
  write_geometry_video(file_, images);
  const std::string whole = bytes_of(file_);
  put_bytes(file_, whole.substr(0, whole.size() * 6 / 10));
  GeometryVideoReader reader(file_);
  EXPECT_EQ(reader.frame_count(), 10);
  for (int i = 0; i < 5; ++i) EXPECT_LT(largest_distance(reader.read(i), images[static_cast<std::size_t>(i)]), 2e-5F);
  try {
    reader.read(9);
    ADD_FAILURE() << "a frame that is not there was read";
  } catch (const CorruptData& error) {
    EXPECT_THAT(error.what(), HasSubstr(file_.string()));
    EXPECT_THAT(error.what(), HasSubstr("cut short"));
  }
  EXPECT_LT(largest_distance(reader.read(2), images[2]), 2e-5F);  // the reader goes on after it
}

// Whatever is cut off or flipped: either the pixels are right, or CorruptData. (The header is text without a checksum.)
TEST_F(GeometryVideo, NeverGivesWrongPixelsInSilence) {
  const auto images = travelling_ball(3, 2);
  write_geometry_video(file_, images);
  const std::string whole = bytes_of(file_);
  int refused = 0, right = 0;
  const auto try_read = [&](const std::string& bytes) {
    put_bytes(file_, bytes);
    try {
      GeometryVideoReader reader(file_);
      for (int i = 0; i < reader.frame_count() && i < 3; ++i) {
        const GeometryImage image = reader.read_in_place(i, reader.header().level);
        ++right;
        ASSERT_EQ(image.colours, images[static_cast<std::size_t>(i)].colours);
      }
    } catch (const CorruptData&) {
      ++refused;
    }
  };
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150)
    try_read(whole.substr(0, length));
  std::mt19937 random(7);
  for (int i = 0; i < 150; ++i) {
    std::string flipped = whole;
    char& byte = flipped[random() % whole.size()];
    byte = static_cast<char>(byte ^ (1 << (random() % 8)));
    try_read(flipped);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(right, 100);
}

void write(const std::filesystem::path& file, const std::vector<GeometryImage>& images, VideoProfile profile,
           bool aligned = false) {
  GeometryVideoHeader header;
  header.profile = profile;
  header.aligned = aligned;
  MeanSurface mean;
  for (const auto& image : images) {
    add_frame(header, image);
    if (profile != VideoProfile::float32) mean.add(image.positions, header.root_path.back());
  }
  GeometryVideoWriter writer(file, header, mean);
  for (const auto& image : images) writer.write(image);
  writer.finish();
}

TEST_F(GeometryVideo, OfProfileMasterWithAMeanIsAsTrueAndSmaller) {
  const auto images = travelling_ball(12, 6);
  write_geometry_video(folder_ / "without.mkv", images);
  for (const char* name : {"with.mkv", "with.avi"}) {
    write(folder_ / name, images, VideoProfile::master);
    EXPECT_LT(std::filesystem::file_size(folder_ / name), std::filesystem::file_size(folder_ / "without.mkv")) << name;
    GeometryVideoReader reader(folder_ / name);
    EXPECT_EQ(reader.header().version, 3);
    for (const int frame : {11, 0, 5}) {  // half a step of 0.039 mm along each axis
      EXPECT_LT(largest_distance(reader.read(frame), images[static_cast<std::size_t>(frame)]), 3.6e-5F) << name;
      EXPECT_EQ(reader.read(frame).colours, images[static_cast<std::size_t>(frame)].colours);
    }
  }
}

TEST_F(GeometryVideo, AsAviLiesBesideItsHeader) {
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

TEST_F(GeometryVideo, ReadForDrawingIsTheSameWithoutNormalsAndCoverage) {
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

TEST_F(GeometryVideo, BetweenFramesIsTheirBlendWhereSamplesCorrespond) {
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

TEST_F(GeometryVideo, OfProfileFloatKeepsWhatFloatsHold) {
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

TEST_F(GeometryVideo, OfProfileStreamIsSmallerAndCloseWhicheverFrameComesFirst) {
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

TEST_F(GeometryVideo, OfProfileStreamTellsDamageByItsChecksums) {
  const auto images = travelling_ball(6, 6);
  write(file_, images, VideoProfile::stream);
  std::vector<GeometryImage> whole;
  {
    GeometryVideoReader reader(file_);
    for (int i = 0; i < 6; ++i) whole.push_back(reader.read(i));
  }
  const std::string bytes = bytes_of(file_);
  std::mt19937 random(5);
  int refused = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::string flipped = bytes;
    flipped[bytes.size() / 2 + random() % (bytes.size() / 2)] ^= 0x10;  // behind the header and the mean
    put_bytes(file_, flipped);
    try {
      GeometryVideoReader reader(file_);
      for (int i = 0; i < 6; ++i) {
        const auto image = reader.read(i);
        ASSERT_EQ(image.colours, whole[static_cast<std::size_t>(i)].colours);
        ASSERT_EQ(image.positions, whole[static_cast<std::size_t>(i)].positions);
      }
    } catch (const CorruptData&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

TEST_F(GeometryVideo, OtherFilesAreRefusedByName) {
  EXPECT_THROW(GeometryVideoReader(folder_ / "none.mkv"), std::system_error);
  put_bytes(file_, "this is not a video");
  EXPECT_THROW(GeometryVideoReader{file_}, CorruptData);
  put_bytes(file_, "");
  EXPECT_THROW(GeometryVideoReader{file_}, CorruptData);
}

TEST_F(GeometryVideo, PaperModeComesBackToHalfALevel) {
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

TEST_F(GeometryVideo, PicturesShowPositionsAndColours) {
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
