#include "capture/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::array<std::pair<PixelFormat, std::string_view>, 7> kFormats{{
    {PixelFormat::mono8, "Mono8"},
    {PixelFormat::bayer_rg8, "BayerRG8"},
    {PixelFormat::bayer_gr8, "BayerGR8"},
    {PixelFormat::bayer_gb8, "BayerGB8"},
    {PixelFormat::bayer_bg8, "BayerBG8"},
    {PixelFormat::rgb8, "RGB8"},
    {PixelFormat::bayer_rg12p, "BayerRG12p"},
}};

constexpr std::array<std::pair<HoleReason, std::string_view>, 7> kReasons{{
    {HoleReason::late, "late"},
    {HoleReason::packets_lost, "packets lost"},
    {HoleReason::camera_lost, "camera lost"},
    {HoleReason::trigger_missed, "trigger missed"},
    {HoleReason::disk_too_slow, "disk too slow"},
    {HoleReason::not_recorded, "not recorded"},
    {HoleReason::corrupt, "corrupt"},
}};

template <class Table, class Value>
std::string_view name_in(const Table& table, Value value) {
  return std::find_if(table.begin(), table.end(), [&](const auto& row) { return row.first == value; })->second;
}

template <class Value, std::size_t N>
std::optional<Value> value_in(const std::array<std::pair<Value, std::string_view>, N>& table, std::string_view name) {
  const auto row = std::find_if(table.begin(), table.end(), [&](const auto& entry) { return entry.second == name; });
  if (row == table.end()) return std::nullopt;
  return row->first;
}

}  // namespace

RigClock::time_point RigClock::now() noexcept {
  timespec moment{};
  clock_gettime(CLOCK_TAI, &moment);
  return time_point{std::chrono::seconds{moment.tv_sec} + std::chrono::nanoseconds{moment.tv_nsec}};
}

std::size_t bytes_per_pixel(PixelFormat format) {
  if (format == PixelFormat::bayer_rg12p) return 2;
  return format == PixelFormat::rgb8 ? 3 : 1;
}

std::size_t image_bytes(int width, int height, PixelFormat format) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return format == PixelFormat::bayer_rg12p ? (pixels * 12 + 7) / 8 : pixels * bytes_per_pixel(format);
}

std::string_view to_string(PixelFormat format) {
  return name_in(kFormats, format);
}

std::optional<PixelFormat> pixel_format_from(std::string_view genicam_name) {
  return value_in(kFormats, genicam_name);
}

std::string_view to_string(HoleReason reason) {
  return name_in(kReasons, reason);
}

std::optional<HoleReason> hole_reason_from(std::string_view words) {
  return value_in(kReasons, words);
}

std::span<const HoleReason> hole_reasons() {
  static constexpr auto reasons = [] {
    std::array<HoleReason, kReasons.size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = kReasons[i].first;
    return all;
  }();
  return reasons;
}

Image make_image(int width, int height, PixelFormat format, std::vector<std::uint8_t> bytes) {
  Image image{.width = width, .height = height, .format = format, .pixels = nullptr};
  if (bytes.size() < image.size_bytes())
    throw InvalidInput(fmt::format("an image of {} x {} {} needs {} bytes, not {}", width, height, to_string(format),
                                   image.size_bytes(), bytes.size()));
  const auto owner = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  image.pixels = {owner, owner->data()};
  return image;
}

bool FrameSet::complete() const {
  return std::all_of(slots.begin(), slots.end(), [](const FrameSlot& slot) { return slot.frame.has_value(); });
}

}  // namespace rotunda::capture
