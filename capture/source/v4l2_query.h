#pragma once
// What a V4L2 driver says of its node, and how a format is asked of it. The kernel's documentation: Video for Linux
// API, VIDIOC_QUERYCAP, VIDIOC_ENUM_FMT, VIDIOC_S_FMT. Nothing here throws: what the driver does not tell is empty.
#include <linux/videodev2.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "capture/source/v4l2_system.h"

namespace rotunda::capture {

constexpr std::uint32_t kMostRows = 256;  // of a list the driver gives

// A driver's field of characters, which a zero may end.
template <std::size_t Size>
std::string text(const __u8 (&field)[Size]) {
  const auto* begin = reinterpret_cast<const char*>(field);
  return {begin, strnlen(begin, Size)};
}

std::uint32_t capabilities_of(const v4l2_capability& capability);  // V4L2_CAP_... of the node itself
bool captures(const v4l2_capability& capability);
std::uint32_t capture_type(const v4l2_capability& capability);  // V4L2_BUF_TYPE_VIDEO_CAPTURE, or ..._MPLANE
std::vector<v4l2_fmtdesc> formats_of(const V4l2Node& node, std::uint32_t type);

// What is common to the two kinds of format.
struct Agreed {
  std::uint32_t width = 0, height = 0, fourcc = 0, field = 0, colorspace = 0, ycbcr = 0, quantization = 0;
  std::uint32_t row_bytes = 0, bytes = 0, planes = 1;
};
Agreed agreed_in(const v4l2_format& format);
// Progressive, width x height pixels, otherwise as the driver chooses; `format` gives the kind.
v4l2_format wanted_format(v4l2_format format, std::uint32_t width, std::uint32_t height, std::uint32_t fourcc);

std::string rate_text(const v4l2_fract& interval);  // "29.97", hertz
v4l2_fract interval_of(double rate_hz);             // seconds between frames
// What to say where the rows of a frame were not seen at one moment; empty otherwise.
std::string field_warning(std::uint32_t field);

}  // namespace rotunda::capture
