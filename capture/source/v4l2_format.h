#pragma once
// The kernel's pixel formats (FourCC) and colorimetry in our words, and images out of the driver's memory.
// The kernel's documentation: Video for Linux API, "Image Formats" and "Colorspaces".
#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

std::vector<std::uint32_t> fourccs_of(PixelFormat format);  // in the order to try them; none: V4L2 has it not
std::optional<PixelFormat> pixel_format_of(std::uint32_t fourcc);
std::string fourcc_text(std::uint32_t fourcc);  // "H264"

// What a driver's colorspace, ycbcr_enc and quantization mean, defaults filled in as the kernel's macros do.
// `exact` is false where the nearest of ours stands for something else (BT.2020, SMPTE 240M).
struct Colorimetry {
  YcbcrCoding coding = YcbcrCoding::bt601_limited;
  bool exact = true;
};
Colorimetry colorimetry_of(std::uint32_t colorspace, std::uint32_t ycbcr_encoding, std::uint32_t quantization);

// How the driver lays an image in a buffer: `row_bytes` from one row's first byte to the next's (of each plane of
// nv12), at least as many as a row's pixels take.
struct BufferLayout {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
  std::size_t row_bytes = 0;
};
std::size_t bytes_in_row(int width, PixelFormat format);  // of pixels alone
std::size_t bytes_needed(const BufferLayout& layout);     // up to the last pixel; 0 for mjpeg
// Copies without the padding. `from` has bytes_needed, `to` image_bytes.
void copy_image(const BufferLayout& layout, std::span<const std::uint8_t> from, std::uint8_t* to);

}  // namespace rotunda::capture
