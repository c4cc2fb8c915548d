#include "capture/source/v4l2_query.h"

#include <fmt/format.h>

#include <cmath>

namespace rotunda::capture {

std::uint32_t capabilities_of(const v4l2_capability& capability) {
  return (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
}

bool captures(const v4l2_capability& capability) {
  constexpr std::uint32_t capture = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE;
  return (capabilities_of(capability) & capture) != 0;
}

std::vector<v4l2_fmtdesc> formats_of(const V4l2Node& node, std::uint32_t type) {
  std::vector<v4l2_fmtdesc> formats;
  for (std::uint32_t i = 0; i < kMostRows; ++i) {
    v4l2_fmtdesc told{};
    told.index = i;
    told.type = type;
    if (!node.ask(VIDIOC_ENUM_FMT, told)) break;
    formats.push_back(told);
  }
  return formats;
}

std::uint32_t capture_type(const v4l2_capability& capability) {
  return (capabilities_of(capability) & V4L2_CAP_VIDEO_CAPTURE) != 0 ? V4L2_BUF_TYPE_VIDEO_CAPTURE
                                                                     : V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
}

Agreed agreed_in(const v4l2_format& format) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE) {
    const auto& pix = format.fmt.pix;
    return {pix.width,     pix.height,       pix.pixelformat,  pix.field,     pix.colorspace,
            pix.ycbcr_enc, pix.quantization, pix.bytesperline, pix.sizeimage, 1};
  }
  const auto& pix = format.fmt.pix_mp;
  return {pix.width,
          pix.height,
          pix.pixelformat,
          pix.field,
          pix.colorspace,
          pix.ycbcr_enc,
          pix.quantization,
          pix.plane_fmt[0].bytesperline,
          pix.plane_fmt[0].sizeimage,
          pix.num_planes};
}

v4l2_format wanted_format(v4l2_format format, std::uint32_t width, std::uint32_t height, std::uint32_t fourcc) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE) {
    v4l2_pix_format pix{};  // row length and size are the driver's to choose
    pix.width = width;
    pix.height = height;
    pix.pixelformat = fourcc;
    pix.field = V4L2_FIELD_NONE;
    format.fmt.pix = pix;
  } else {
    v4l2_pix_format_mplane pix{};
    pix.width = width;
    pix.height = height;
    pix.pixelformat = fourcc;
    pix.field = V4L2_FIELD_NONE;
    pix.num_planes = 1;
    format.fmt.pix_mp = pix;
  }
  return format;
}

std::string rate_text(const v4l2_fract& interval) {
  return interval.numerator == 0 ? "?" : fmt::format("{:g}", double{1} * interval.denominator / interval.numerator);
}

v4l2_fract interval_of(double rate_hz) {
  const double whole = std::round(rate_hz);
  if (std::abs(rate_hz - whole) < 1e-6) return {1, static_cast<std::uint32_t>(whole)};
  return {1000, static_cast<std::uint32_t>(std::lround(rate_hz * 1000.0))};
}

std::string field_warning(std::uint32_t field) {
  if (field == V4L2_FIELD_INTERLACED || field == V4L2_FIELD_INTERLACED_TB || field == V4L2_FIELD_INTERLACED_BT)
    return "its frames are interlaced: every second row is half a frame older, and what moves shows combs; set the "
           "camera to a progressive mode if it has one";
  return "";
}

}  // namespace rotunda::capture
