#pragma once
// A studio of small simulated cameras whose pixels tell camera and time, for tests that stream for real.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "simulator/gige/gige_studio.h"

namespace rotunda::tests {

struct TestStudioOptions {
  std::size_t cameras = 1;
  int width = 160, height = 120;
  capture::PixelFormat format = capture::PixelFormat::bayer_rg8;
  std::uint8_t first_address = 1;  // 127.0.0.x
  simulator::CameraClockOptions clock;
  std::optional<std::uint16_t> trigger_box_port;
};

class TestStudio {
 public:
  explicit TestStudio(const TestStudioOptions& options)
      : options_(options),
        kept_(options.cameras),
        calls_(options.cameras),
        studio_(cameras(),
                [this](std::size_t camera, capture::Timestamp at) {
                  auto& slot = kept_[camera][calls_[camera]++ % kept_[camera].size()];
                  slot = picture(camera, at);
                  return std::span<const std::uint8_t>{slot};
                },
                {.trigger_box_port = options.trigger_box_port}) {
    studio_.start();
  }

  std::vector<simulator::GigeCameraOptions> cameras() const {
    std::vector<simulator::GigeCameraOptions> all;
    for (std::size_t i = 0; i < options_.cameras; ++i)
      all.push_back({.name = fmt::format("cam{:02}", i),
                     .serial = fmt::format("RS{:04}", i),
                     .address = address(i),
                     .mac = {0x02, 0x52, 0x54, 0, 0, static_cast<std::uint8_t>(i + options_.first_address)},
                     .width = options_.width,
                     .height = options_.height,
                     .format = options_.format,
                     .clock = options_.clock});
    return all;
  }

  std::string address(std::size_t camera) const { return fmt::format("127.0.0.{}", camera + options_.first_address); }

  // What `camera` shows at that time: every picture differs from every other, and so do its rows.
  std::vector<std::uint8_t> picture(std::size_t camera, capture::Timestamp at) const {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(options_.width) *
                                     static_cast<std::size_t>(options_.height) *
                                     capture::bytes_per_pixel(options_.format));
    std::uint64_t state = static_cast<std::uint64_t>(at.time_since_epoch().count()) * 31 + camera;
    for (auto& pixel : pixels) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      pixel = static_cast<std::uint8_t>(state >> 56);
    }
    return pixels;
  }

  simulator::GigeStudio& operator*() { return studio_; }
  std::vector<simulator::GigeStats> stats() const { return studio_.stats(); }

 private:
  TestStudioOptions options_;
  std::vector<std::array<std::vector<std::uint8_t>, 64>> kept_;  // longer than the eight calls a picture must last
  std::vector<std::size_t> calls_;                               // sender thread only
  simulator::GigeStudio studio_;
};

}  // namespace rotunda::tests
