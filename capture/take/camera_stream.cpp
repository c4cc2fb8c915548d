#include "capture/take/camera_stream.h"

#include <algorithm>
#include <array>

extern "C" {
#include <libavcodec/avcodec.h>
}

namespace rotunda::capture {
namespace {

// Y'CbCr goes in under the name that players know it by, so that they show its colours.
struct YcbcrStream {
  PixelFormat format;
  std::uint32_t tag;
  AVPixelFormat av_format;
};
constexpr std::array kYcbcrStreams{
    YcbcrStream{PixelFormat::yuyv, MKTAG('Y', 'U', 'Y', '2'), AV_PIX_FMT_YUYV422},
    YcbcrStream{PixelFormat::uyvy, MKTAG('U', 'Y', 'V', 'Y'), AV_PIX_FMT_UYVY422},
    YcbcrStream{PixelFormat::nv12, MKTAG('N', 'V', '1', '2'), AV_PIX_FMT_NV12},
};

void describe_ycbcr(AVCodecParameters& parameters, const TakeCamera& camera) {
  const auto stream = std::find_if(kYcbcrStreams.begin(), kYcbcrStreams.end(),
                                   [&](const auto& row) { return row.format == camera.format; });
  parameters.codec_id = AV_CODEC_ID_RAWVIDEO;
  parameters.codec_tag = stream->tag;
  parameters.format = stream->av_format;
  parameters.width = camera.width;
  describe_colours(parameters, camera.ycbcr);
}

void describe_jpeg(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_id = AV_CODEC_ID_MJPEG;
  parameters.format = AV_PIX_FMT_YUVJ422P;
  parameters.width = camera.width;
  describe_colours(parameters, YcbcrCoding::bt601_full);
}

// Samples as grey, as wide as a row has bytes: packed and 16-bit pixels are not bytes.
void describe_samples(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_id = AV_CODEC_ID_RAWVIDEO;
  parameters.codec_tag = MKTAG('Y', '8', '0', '0');
  parameters.format = AV_PIX_FMT_GRAY8;
  const auto rows = static_cast<std::size_t>(camera.height);
  parameters.width = static_cast<int>((image_bytes(camera.width, camera.height, camera.format) + rows - 1) / rows);
}

}  // namespace

void describe_colours(AVCodecParameters& parameters, YcbcrCoding coding) {
  const bool bt709 = coding == YcbcrCoding::bt709_limited || coding == YcbcrCoding::bt709_full;
  const bool full = coding == YcbcrCoding::bt601_full || coding == YcbcrCoding::bt709_full;
  parameters.color_space = bt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  parameters.color_range = full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
}

YcbcrCoding coding_of(const AVCodecParameters& parameters) {
  const bool full = parameters.color_range == AVCOL_RANGE_JPEG;
  if (parameters.color_space == AVCOL_SPC_BT709) return full ? YcbcrCoding::bt709_full : YcbcrCoding::bt709_limited;
  return full ? YcbcrCoding::bt601_full : YcbcrCoding::bt601_limited;
}

void describe_as_it_came(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_type = AVMEDIA_TYPE_VIDEO;
  parameters.height = camera.height;
  if (camera.format == PixelFormat::mjpeg)
    describe_jpeg(parameters, camera);
  else if (is_ycbcr(camera.format))
    describe_ycbcr(parameters, camera);
  else
    describe_samples(parameters, camera);
}

bool is_as_it_came(const AVCodecParameters& parameters, PixelFormat format) {
  const auto codec = format == PixelFormat::mjpeg ? AV_CODEC_ID_MJPEG : AV_CODEC_ID_RAWVIDEO;
  return format != PixelFormat::rgb8 && parameters.codec_id == codec;
}

int pixels_across(const AVCodecParameters& parameters, PixelFormat format) {
  const bool bytes_as_grey = is_as_it_came(parameters, format) && format != PixelFormat::mjpeg && !is_ycbcr(format);
  return bytes_as_grey ? parameters.width * 8 / layout_of(format).stored_bits : parameters.width;
}

}  // namespace rotunda::capture
