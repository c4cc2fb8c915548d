#include "capture/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::array<std::pair<PixelFormat, std::string_view>, 7> kNames{{
    {PixelFormat::mono8, "Mono8"},
    {PixelFormat::bayer_rg8, "BayerRG8"},
    {PixelFormat::bayer_gr8, "BayerGR8"},
    {PixelFormat::bayer_gb8, "BayerGB8"},
    {PixelFormat::bayer_bg8, "BayerBG8"},
    {PixelFormat::rgb8, "RGB8"},
    {PixelFormat::bayer_rg12p, "BayerRG12p"},
}};

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
  return std::find_if(kNames.begin(), kNames.end(), [&](const auto& row) { return row.first == format; })->second;
}

std::optional<PixelFormat> pixel_format_from(std::string_view genicam_name) {
  const auto row =
      std::find_if(kNames.begin(), kNames.end(), [&](const auto& entry) { return entry.second == genicam_name; });
  if (row == kNames.end()) return std::nullopt;
  return row->first;
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
