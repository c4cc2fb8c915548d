#include "capture/source/v4l2_format.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace rotunda::capture {
namespace {

constexpr std::array<std::pair<PixelFormat, std::uint32_t>, 27> kFourccs{{
    {PixelFormat::mono8, V4L2_PIX_FMT_GREY},
    {PixelFormat::rgb8, V4L2_PIX_FMT_RGB24},
    {PixelFormat::bayer_rg8, V4L2_PIX_FMT_SRGGB8},
    {PixelFormat::bayer_gr8, V4L2_PIX_FMT_SGRBG8},
    {PixelFormat::bayer_gb8, V4L2_PIX_FMT_SGBRG8},
    {PixelFormat::bayer_bg8, V4L2_PIX_FMT_SBGGR8},
    {PixelFormat::bayer_rg10, V4L2_PIX_FMT_SRGGB10},
    {PixelFormat::bayer_gr10, V4L2_PIX_FMT_SGRBG10},
    {PixelFormat::bayer_gb10, V4L2_PIX_FMT_SGBRG10},
    {PixelFormat::bayer_bg10, V4L2_PIX_FMT_SBGGR10},
    {PixelFormat::bayer_rg12, V4L2_PIX_FMT_SRGGB12},
    {PixelFormat::bayer_gr12, V4L2_PIX_FMT_SGRBG12},
    {PixelFormat::bayer_gb12, V4L2_PIX_FMT_SGBRG12},
    {PixelFormat::bayer_bg12, V4L2_PIX_FMT_SBGGR12},
    {PixelFormat::bayer_rg10_csi2p, V4L2_PIX_FMT_SRGGB10P},
    {PixelFormat::bayer_gr10_csi2p, V4L2_PIX_FMT_SGRBG10P},
    {PixelFormat::bayer_gb10_csi2p, V4L2_PIX_FMT_SGBRG10P},
    {PixelFormat::bayer_bg10_csi2p, V4L2_PIX_FMT_SBGGR10P},
    {PixelFormat::bayer_rg12_csi2p, V4L2_PIX_FMT_SRGGB12P},
    {PixelFormat::bayer_gr12_csi2p, V4L2_PIX_FMT_SGRBG12P},
    {PixelFormat::bayer_gb12_csi2p, V4L2_PIX_FMT_SGBRG12P},
    {PixelFormat::bayer_bg12_csi2p, V4L2_PIX_FMT_SBGGR12P},
    {PixelFormat::yuyv, V4L2_PIX_FMT_YUYV},
    {PixelFormat::uyvy, V4L2_PIX_FMT_UYVY},
    {PixelFormat::nv12, V4L2_PIX_FMT_NV12},
    {PixelFormat::mjpeg, V4L2_PIX_FMT_MJPEG},
    {PixelFormat::mjpeg, V4L2_PIX_FMT_JPEG},
}};

bool is_bt709(std::uint32_t encoding) {
  return encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709;
}
bool is_bt601(std::uint32_t encoding) {
  return encoding == V4L2_YCBCR_ENC_601 || encoding == V4L2_YCBCR_ENC_XV601;
}

std::size_t rows_of(const BufferLayout& layout) {
  const auto rows = static_cast<std::size_t>(layout.height);
  return layout.format == PixelFormat::nv12 ? rows + rows / 2 : rows;
}

}  // namespace

std::vector<std::uint32_t> fourccs_of(PixelFormat format) {
  std::vector<std::uint32_t> found;
  for (const auto& [ours, fourcc] : kFourccs)
    if (ours == format) found.push_back(fourcc);
  return found;
}

std::optional<PixelFormat> pixel_format_of(std::uint32_t fourcc) {
  for (const auto& [ours, theirs] : kFourccs)
    if (theirs == fourcc) return ours;
  return std::nullopt;
}

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>(fourcc >> shift & 0x7FU);  // the top bit marks big-endian kinds
    text += letter >= ' ' && letter <= '~' ? letter : '?';
  }
  return text;
}

Colorimetry colorimetry_of(std::uint32_t colorspace, std::uint32_t ycbcr_encoding, std::uint32_t quantization) {
  const std::uint32_t encoding =
      ycbcr_encoding == V4L2_YCBCR_ENC_DEFAULT ? std::uint32_t{V4L2_MAP_YCBCR_ENC_DEFAULT(colorspace)} : ycbcr_encoding;
  // Of Y'CbCr only JPEG's colour space is full range by default.
  const bool full = quantization == V4L2_QUANTIZATION_DEFAULT ? colorspace == V4L2_COLORSPACE_JPEG
                                                              : quantization == V4L2_QUANTIZATION_FULL_RANGE;
  if (is_bt601(encoding)) return {full ? YcbcrCoding::bt601_full : YcbcrCoding::bt601_limited, true};
  return {full ? YcbcrCoding::bt709_full : YcbcrCoding::bt709_limited, is_bt709(encoding)};
}

std::size_t bytes_in_row(int width, PixelFormat format) {
  if (format == PixelFormat::nv12) return static_cast<std::size_t>(width);  // in either plane
  return image_bytes(width, 1, format);
}

std::size_t bytes_needed(const BufferLayout& layout) {
  if (layout.format == PixelFormat::mjpeg) return 0;
  return (rows_of(layout) - 1) * layout.row_bytes + bytes_in_row(layout.width, layout.format);
}

void copy_image(const BufferLayout& layout, std::span<const std::uint8_t> from, std::uint8_t* to) {
  const std::size_t row = bytes_in_row(layout.width, layout.format);
  if (layout.row_bytes == row) {
    std::memcpy(to, from.data(), row * rows_of(layout));
    return;
  }
  for (std::size_t i = 0; i < rows_of(layout); ++i) std::memcpy(to + i * row, from.data() + i * layout.row_bytes, row);
}

}  // namespace rotunda::capture
