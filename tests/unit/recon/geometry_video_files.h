#pragma once
// What the tests of geometry videos share: a folder of their own, and a ball whose every frame differs.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "recon/video/geometry_video.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::test {

using recon::add_frame, recon::GeometryImage, recon::GeometryVideoHeader, recon::GeometryVideoWriter,
    recon::MeanSurface, recon::VideoProfile;

class GeometryVideoTest : public ::testing::Test {
 protected:
  GeometryVideoTest() { std::filesystem::create_directories(folder_); }
  ~GeometryVideoTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("rotunda_geometry_video_" + std::to_string(::getpid()));
  std::filesystem::path file_ = folder_ / "geometry.mkv";
};

// A ball that travels four metres and breathes, so that every frame differs.
inline std::vector<GeometryImage> travelling_ball(int frames, int level = 5) {
  std::vector<GeometryImage> images;
  for (int i = 0; i < frames; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(frames);
    images.push_back(round_geometry_image({.level = level,
                                           .colour_level = level + 1,
                                           .centre = {4.0F * t - 2.0F, 0.3F, 1.0F},
                                           .radii = {0.5F + 0.1F * t, 0.4F, 0.6F}}));
    images.back().colours[7] = {static_cast<std::uint8_t>(i), 1, 2};
  }
  return images;
}

inline float largest_distance(const GeometryImage& a, const GeometryImage& b) {
  float distance = 0.0F;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    distance = std::max(distance, (a.positions[i] - b.positions[i]).norm());
  return distance;
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

inline void write(const std::filesystem::path& file, const std::vector<GeometryImage>& images, VideoProfile profile,
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

}  // namespace rotunda::test
