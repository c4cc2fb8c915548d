#include "simulator/studio/re_exposure.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "simulator/studio/sensor_response.h"

namespace rotunda::simulator {
namespace {

using capture::PixelFormat;

// Noise is looked up in steps of an eighth of its standard deviation.
constexpr std::size_t kLevels = 64;
constexpr float kReach = 4.0F;  // standard deviations

float noise_of(std::size_t level) {
  return kReach * (2.0F * static_cast<float>(level) / (kLevels - 1) - 1.0F);
}

const std::vector<std::uint8_t>& levels_of_normals() {
  static const auto table = [] {
    std::vector<std::uint8_t> levels;
    for (const float normal : normals()) {
      const float level = std::round((normal / kReach + 1.0F) / 2.0F * (kLevels - 1));
      levels.push_back(static_cast<std::uint8_t>(std::clamp(level, 0.0F, static_cast<float>(kLevels - 1))));
    }
    return levels;
  }();
  return table;
}

// From s = m + sqrt(m + r^2) z, what the converter was given, to the expected electrons m.
float expected_electrons(float s, float z, float read_noise) {
  const float r2 = read_noise * read_noise;
  const float u = 0.5F * (std::sqrt(z * z + 4.0F * (s + r2)) - z);
  return std::max(0.0F, u * u - r2);
}

// A picture's samples, one after the other from its first pixel to its last.
struct Samples8 {
  static std::uint16_t get(std::span<const std::uint8_t> bytes, std::size_t i) { return bytes[i]; }
  static void set(std::span<std::uint8_t> bytes, std::size_t i, std::uint16_t value) {
    bytes[i] = static_cast<std::uint8_t>(value);
  }
};
struct Samples12p {
  static std::uint16_t get(std::span<const std::uint8_t> bytes, std::size_t i) {
    const auto* at = &bytes[i / 2 * 3];
    return static_cast<std::uint16_t>(i % 2 == 0 ? at[0] | (at[1] & 0x0F) << 8 : at[1] >> 4 | at[2] << 4);
  }
  static void set(std::span<std::uint8_t> zeroed, std::size_t i, std::uint16_t value) {
    auto* at = &zeroed[i / 2 * 3];
    if (i % 2 == 0) {
      at[0] = static_cast<std::uint8_t>(value & 0xFF);
      at[1] = static_cast<std::uint8_t>(at[1] | value >> 8);
    } else {
      at[1] = static_cast<std::uint8_t>(at[1] | (value & 0x0F) << 4);
      at[2] = static_cast<std::uint8_t>(value >> 4);
    }
  }
};

// As pixel_encoding lays the channels.
class Channels {
 public:
  Channels(PixelFormat format, std::size_t row)
      : is_mosaic_(format != PixelFormat::mono8),
        row_(row + (format == PixelFormat::bayer_gb8 || format == PixelFormat::bayer_bg8)),
        right_(format == PixelFormat::bayer_gr8 || format == PixelFormat::bayer_bg8) {}
  std::size_t of_column(std::size_t x) const { return is_mosaic_ ? (row_ & 1) + ((x + right_) & 1) : 1; }

 private:
  bool is_mosaic_;
  std::size_t row_, right_;
};

}  // namespace

ExposureSettings rendered_settings(const SensorOptions& options, std::size_t camera) {
  const auto settings = settings_of(options, camera);
  return {settings.exposure_s, settings.gain_db, {settings.red_balance, 1.0, settings.blue_balance}};
}

ReExposure::ReExposure(const SensorOptions& rendered, std::size_t camera, PixelFormat format, int width)
    : rendered_(rendered),
      camera_(camera),
      format_(format),
      width_(static_cast<std::size_t>(width)),
      codes_(format == PixelFormat::bayer_rg12p ? kFullScale + 1 : 256) {}

// Of each of the picture's codes: the middle of what the converter may have been given. Codes no converter's code
// comes to take their lower neighbour's.
std::vector<float> ReExposure::electrons_of_codes(std::size_t channel) const {
  const auto was = rendered_settings(rendered_, camera_);
  const auto response = sensor_response(rendered_, camera_, was.gain_db, was.balance);
  std::vector<float> sums(static_cast<std::size_t>(codes_)), counts(sums.size());
  for (std::size_t code = 0; code <= kFullScale; ++code) {
    const auto shown = static_cast<std::size_t>(picture_code(response.curve[channel][code]));
    if (shown + 1 == sums.size() && counts[shown] > 0.0F) break;  // saturated: the least that does so
    sums[shown] += static_cast<float>(code) / response.codes_per_electron;
    ++counts[shown];
  }
  for (std::size_t code = 0; code < sums.size(); ++code)
    sums[code] = counts[code] > 0.0F ? sums[code] / counts[code] : code > 0 ? sums[code - 1] : 0.0F;
  return sums;
}

int ReExposure::picture_code(std::uint16_t curved) const {
  return codes_ == 256 ? static_cast<int>(std::lround(curved * 255.0 / kFullScale)) : curved;
}

ReExposure::Table ReExposure::table_of(std::size_t channel, const ExposureSettings& settings) const {
  const auto response = sensor_response(rendered_, camera_, settings.gain_db, settings.balance);
  const auto ratio = static_cast<float>(settings.exposure_s / rendered_settings(rendered_, camera_).exposure_s);
  const float r2 = response.read_noise * response.read_noise;
  const auto electrons = electrons_of_codes(channel);
  Table table(electrons.size() * kLevels);
  for (std::size_t code = 0; code < electrons.size(); ++code)
    for (std::size_t level = 0; level < kLevels; ++level) {
      const float z = noise_of(level);
      const float mean = ratio * expected_electrons(electrons[code], z, response.read_noise);
      const float given = response.codes_per_electron * (mean + std::sqrt(mean + r2) * z) + 0.5F;
      const auto converted = static_cast<std::size_t>(std::clamp(given, 0.0F, static_cast<float>(kFullScale)));
      table[code * kLevels + level] = static_cast<std::uint16_t>(picture_code(response.curve[channel][converted]));
    }
  return table;
}

void ReExposure::make_tables(const ExposureSettings& settings) {
  if (settings_ == settings) return;
  for (std::size_t channel = 0; channel < 3; ++channel) tables_[channel] = table_of(channel, settings);
  settings_ = settings;
}

// Of one row, which starts at sample `first`. The noise is drawn as Sensor::expose does: three for each pixel.
template <class Samples>
void ReExposure::convert_row(const Picture& picture, std::size_t y) const {
  const auto& levels = levels_of_normals();
  const Channels channels(format_, y);
  RowNoise noise(camera_, picture.frame, static_cast<int>(y), rendered_.seed);
  for (std::size_t x = 0; x < width_; ++x) {
    const std::array<unsigned, 3> drawn{noise.next_index(), noise.next_index(), noise.next_index()};
    const auto convert = [&](std::size_t channel, std::size_t sample) {
      const std::size_t code = Samples::get(picture.from, sample);
      Samples::set(picture.to, sample, tables_[channel][code * kLevels + levels[drawn[channel]]]);
    };
    if (format_ != PixelFormat::rgb8) {
      convert(channels.of_column(x), y * width_ + x);
      continue;
    }
    for (std::size_t channel = 0; channel < 3; ++channel) convert(channel, 3 * (y * width_ + x) + channel);
  }
}

std::vector<std::uint8_t> ReExposure::operator()(std::span<const std::uint8_t> picture, std::uint64_t frame,
                                                 const ExposureSettings& settings) {
  const bool is_packed = format_ == PixelFormat::bayer_rg12p;
  const std::size_t bits = is_packed ? 12 : format_ == PixelFormat::rgb8 ? 24 : 8;
  const std::size_t rows = 8 * picture.size() / (bits * width_);
  if ((rows * width_ * bits + 7) / 8 != picture.size())
    throw InvalidInput(
        fmt::format("{} bytes are no rows of {} pixels of {}", picture.size(), width_, capture::to_string(format_)));
  make_tables(settings);
  std::vector<std::uint8_t> out(picture.size());
  const Picture all{picture, out, frame};
  // Two rows at least: their samples of 12 bits end at a byte's end.
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, (rows + 1) / 2, 32), [&](const auto& pairs) {
    for (std::size_t y = 2 * pairs.begin(); y < std::min(rows, 2 * pairs.end()); ++y)
      is_packed ? convert_row<Samples12p>(all, y) : convert_row<Samples8>(all, y);
  });
  return out;
}

}  // namespace rotunda::simulator
