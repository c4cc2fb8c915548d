#pragma once
// Small takes of known content, in a folder that goes with the test.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "capture/frame.h"
#include "capture/take/take_writer.h"

namespace rotunda::capture::test {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "rotunda-take-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryFolder() {
    std::error_code best_effort;
    std::filesystem::remove_all(path_, best_effort);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::vector<TakeCamera> cameras_of(std::size_t count, int width = 64, int height = 48,
                                          PixelFormat format = PixelFormat::bayer_rg8) {
  std::vector<TakeCamera> cameras(count);
  for (std::size_t i = 0; i < count; ++i) {
    cameras[i].name = "cam0" + std::to_string(i);
    cameras[i].width = width;
    cameras[i].height = height;
    cameras[i].format = format;
  }
  return cameras;
}

// Noise that depends on camera and trigger alone.
inline Image noise_image(const TakeCamera& camera, std::uint64_t seed) {
  std::vector<std::uint8_t> bytes(
      camera.format == PixelFormat::mjpeg ? 500 + seed % 100 : image_bytes(camera.width, camera.height, camera.format));
  std::uint64_t state = seed * 0x9E3779B97F4A7C15U + 1;
  for (auto& byte : bytes) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    byte = static_cast<std::uint8_t>(state >> 56U);
  }
  return make_image(camera.width, camera.height, camera.format, std::move(bytes), camera.ycbcr);
}

inline Timestamp trigger_time(std::uint64_t trigger) {
  using namespace std::chrono_literals;
  return Timestamp(1'763'772'000'000'000'007ns + 40ms * trigger);
}

inline FrameSet frame_set(const std::vector<TakeCamera>& cameras, std::uint64_t trigger) {
  using namespace std::chrono_literals;
  FrameSet set{.trigger = trigger, .time = trigger_time(trigger), .slots = {}};
  for (std::size_t i = 0; i < cameras.size(); ++i)
    set.slots.push_back({.frame = Frame{.camera = cameras[i].name,
                                        .trigger = trigger,
                                        .exposure_start = set.time + 1ns * static_cast<int>(i),
                                        .exposure = 3'000'123ns,
                                        .image = noise_image(cameras[i], trigger * 100 + i)},
                         .missing_because = std::nullopt});
  return set;
}

inline TakeWriterOptions options_for(const std::filesystem::path& folder, std::vector<TakeCamera> cameras) {
  TakeWriterOptions options;
  options.folder = folder;
  options.cameras = std::move(cameras);
  options.reserve_bytes = 0;
  return options;
}

inline void expect_same(const FrameSet& read, const FrameSet& written) {
  EXPECT_EQ(read.trigger, written.trigger);
  EXPECT_EQ(read.time, written.time);
  ASSERT_EQ(read.slots.size(), written.slots.size());
  for (std::size_t i = 0; i < written.slots.size(); ++i) {
    ASSERT_EQ(read.slots[i].frame.has_value(), written.slots[i].frame.has_value()) << "slot " << i;
    if (!written.slots[i].frame) continue;
    const Frame& a = *read.slots[i].frame;
    const Frame& b = *written.slots[i].frame;
    EXPECT_EQ(a.camera, b.camera);
    EXPECT_EQ(a.trigger, b.trigger);
    EXPECT_EQ(a.exposure_start, b.exposure_start);
    EXPECT_EQ(a.exposure, b.exposure);
    EXPECT_EQ(a.image.format, b.image.format);
    EXPECT_TRUE(
        std::equal(a.image.bytes().begin(), a.image.bytes().end(), b.image.bytes().begin(), b.image.bytes().end()));
  }
}

}  // namespace rotunda::capture::test
