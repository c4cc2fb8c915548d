#pragma once
// A rendered picture as its camera would have given it with other settings: what stands in the frame cache need not be
// rendered again when a client turns exposure, gain or white balance. The picture's codes lead back to electrons
// through the camera's curve and the very noise they were drawn with, so that a longer exposure has less of it beside
// the signal, not the same amplified. Exact to the rounding of the codes, but for three things: motion blur stays that
// of the rendered exposure, what was saturated stays at the light that just saturates, and Mono8 of a colour sensor is
// treated as its green.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/frame.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ExposureSettings {
  double exposure_s = 0.005;
  double gain_db = 0.0;
  std::array<double, 3> balance{1.0, 1.0, 1.0};  // factors on red, green, blue
  bool operator==(const ExposureSettings&) const = default;
};
// Those `camera` was rendered with.
ExposureSettings rendered_settings(const SensorOptions& options, std::size_t camera);

// One camera's. Keeps the tables of the last settings; use from one thread at a time.
class ReExposure {
 public:
  ReExposure(const SensorOptions& rendered, std::size_t camera, capture::PixelFormat format, int width);

  // `picture`: as encode_pixels gave it of Sensor::expose(..., frame). Throws InvalidInput if it is no whole rows.
  std::vector<std::uint8_t> operator()(std::span<const std::uint8_t> picture, std::uint64_t frame,
                                       const ExposureSettings& settings);

 private:
  // Of one channel: what a code becomes, by the noise it was drawn with.
  using Table = std::vector<std::uint16_t>;
  struct Picture {
    std::span<const std::uint8_t> from;
    std::span<std::uint8_t> to;
    std::uint64_t frame;
  };
  template <class Samples>
  void convert_row(const Picture& picture, std::size_t y) const;
  int picture_code(std::uint16_t curved) const;  // of the curve's 12 bits
  void make_tables(const ExposureSettings& settings);
  Table table_of(std::size_t channel, const ExposureSettings& settings) const;
  std::vector<float> electrons_of_codes(std::size_t channel) const;

  SensorOptions rendered_;
  std::size_t camera_;
  capture::PixelFormat format_;
  std::size_t width_;
  int codes_;  // that a sample may have: 256 or 4096
  std::optional<ExposureSettings> settings_;
  std::array<Table, 3> tables_;
};

}  // namespace rotunda::simulator
