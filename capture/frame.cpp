#include "capture/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

struct FormatRow {
  PixelFormat format;
  std::string_view name;
  PixelLayout layout;
};

// V4L2's own names where GenICam's naming convention (PFNC) has none: MIPI packing, and what UVC cameras send.
constexpr std::array<FormatRow, 27> kFormats{{
    {PixelFormat::mono8, "Mono8", {PixelPacking::bytes, BayerOrder::none, 8, 8}},
    {PixelFormat::bayer_rg8, "BayerRG8", {PixelPacking::bytes, BayerOrder::rg, 8, 8}},
    {PixelFormat::bayer_gr8, "BayerGR8", {PixelPacking::bytes, BayerOrder::gr, 8, 8}},
    {PixelFormat::bayer_gb8, "BayerGB8", {PixelPacking::bytes, BayerOrder::gb, 8, 8}},
    {PixelFormat::bayer_bg8, "BayerBG8", {PixelPacking::bytes, BayerOrder::bg, 8, 8}},
    {PixelFormat::rgb8, "RGB8", {PixelPacking::bytes, BayerOrder::none, 8, 24}},
    {PixelFormat::bayer_rg12p, "BayerRG12p", {PixelPacking::pfnc_12p, BayerOrder::rg, 12, 12}},
    {PixelFormat::bayer_rg10, "BayerRG10", {PixelPacking::words, BayerOrder::rg, 10, 16}},
    {PixelFormat::bayer_gr10, "BayerGR10", {PixelPacking::words, BayerOrder::gr, 10, 16}},
    {PixelFormat::bayer_gb10, "BayerGB10", {PixelPacking::words, BayerOrder::gb, 10, 16}},
    {PixelFormat::bayer_bg10, "BayerBG10", {PixelPacking::words, BayerOrder::bg, 10, 16}},
    {PixelFormat::bayer_rg12, "BayerRG12", {PixelPacking::words, BayerOrder::rg, 12, 16}},
    {PixelFormat::bayer_gr12, "BayerGR12", {PixelPacking::words, BayerOrder::gr, 12, 16}},
    {PixelFormat::bayer_gb12, "BayerGB12", {PixelPacking::words, BayerOrder::gb, 12, 16}},
    {PixelFormat::bayer_bg12, "BayerBG12", {PixelPacking::words, BayerOrder::bg, 12, 16}},
    {PixelFormat::bayer_rg10_csi2p, "BayerRG10_CSI2P", {PixelPacking::csi2_10p, BayerOrder::rg, 10, 10}},
    {PixelFormat::bayer_gr10_csi2p, "BayerGR10_CSI2P", {PixelPacking::csi2_10p, BayerOrder::gr, 10, 10}},
    {PixelFormat::bayer_gb10_csi2p, "BayerGB10_CSI2P", {PixelPacking::csi2_10p, BayerOrder::gb, 10, 10}},
    {PixelFormat::bayer_bg10_csi2p, "BayerBG10_CSI2P", {PixelPacking::csi2_10p, BayerOrder::bg, 10, 10}},
    {PixelFormat::bayer_rg12_csi2p, "BayerRG12_CSI2P", {PixelPacking::csi2_12p, BayerOrder::rg, 12, 12}},
    {PixelFormat::bayer_gr12_csi2p, "BayerGR12_CSI2P", {PixelPacking::csi2_12p, BayerOrder::gr, 12, 12}},
    {PixelFormat::bayer_gb12_csi2p, "BayerGB12_CSI2P", {PixelPacking::csi2_12p, BayerOrder::gb, 12, 12}},
    {PixelFormat::bayer_bg12_csi2p, "BayerBG12_CSI2P", {PixelPacking::csi2_12p, BayerOrder::bg, 12, 12}},
    {PixelFormat::yuyv, "YUYV", {PixelPacking::yuyv, BayerOrder::none, 8, 16}},
    {PixelFormat::uyvy, "UYVY", {PixelPacking::uyvy, BayerOrder::none, 8, 16}},
    {PixelFormat::nv12, "NV12", {PixelPacking::nv12, BayerOrder::none, 8, 12}},
    {PixelFormat::mjpeg, "MJPEG", {PixelPacking::jpeg, BayerOrder::none, 8, 0}},
}};

constexpr std::array<std::pair<YcbcrCoding, std::string_view>, 4> kCodings{{
    {YcbcrCoding::bt601_limited, "bt601-limited"},
    {YcbcrCoding::bt601_full, "bt601-full"},
    {YcbcrCoding::bt709_limited, "bt709-limited"},
    {YcbcrCoding::bt709_full, "bt709-full"},
}};

constexpr std::array<std::pair<HoleReason, std::string_view>, 8> kReasons{{
    {HoleReason::late, "late"},
    {HoleReason::packets_lost, "packets lost"},
    {HoleReason::damaged, "damaged"},
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

const FormatRow& row_of(PixelFormat format) {
  return *std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& row) { return row.format == format; });
}

}  // namespace

PixelLayout layout_of(PixelFormat format) {
  return row_of(format).layout;
}

bool is_ycbcr(PixelFormat format) {
  return format == PixelFormat::yuyv || format == PixelFormat::uyvy || format == PixelFormat::nv12;
}

std::string_view to_string(YcbcrCoding coding) {
  return std::find_if(kCodings.begin(), kCodings.end(), [&](const auto& row) { return row.first == coding; })->second;
}

std::optional<YcbcrCoding> ycbcr_coding_from(std::string_view name) {
  for (const auto& [coding, word] : kCodings)
    if (word == name) return coding;
  return std::nullopt;
}

PixelGroup pixel_group(PixelFormat format) {
  switch (layout_of(format).packing) {
    case PixelPacking::csi2_10p:
      return {4, 1};
    case PixelPacking::csi2_12p:
    case PixelPacking::yuyv:
    case PixelPacking::uyvy:
      return {2, 1};
    case PixelPacking::nv12:
      return {2, 2};
    default:
      return {1, 1};
  }
}

std::size_t bytes_per_pixel(PixelFormat format) {
  return static_cast<std::size_t>(layout_of(format).stored_bits + 7) / 8;
}

std::size_t image_bytes(int width, int height, PixelFormat format) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return (pixels * static_cast<std::size_t>(layout_of(format).stored_bits) + 7) / 8;
}

std::string_view to_string(PixelFormat format) {
  return row_of(format).name;
}

std::optional<PixelFormat> pixel_format_from(std::string_view name) {
  const auto row =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& entry) { return entry.name == name; });
  if (row == kFormats.end()) return std::nullopt;
  return row->format;
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

std::vector<PixelFormat> pixel_formats() {
  std::vector<PixelFormat> formats;
  for (const auto& row : kFormats) formats.push_back(row.format);
  return formats;
}

Image make_image(int width, int height, PixelFormat format, std::vector<std::uint8_t> bytes, YcbcrCoding ycbcr) {
  Image image{.width = width, .height = height, .format = format, .pixels = nullptr, .ycbcr = ycbcr};
  if (format == PixelFormat::mjpeg) image.jpeg_bytes = bytes.size();
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
