#include "capture/ycbcr_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>

#include "capture/base/av_objects.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libswscale/swscale.h>
}

namespace rotunda::capture {
namespace {

// Where the samples of a picture lie, for libswscale.
struct Planes {
  std::array<const std::uint8_t*, 4> data{};
  std::array<int, 4> stride{};
  AVPixelFormat format = AV_PIX_FMT_NONE;
};

cv::Mat converted(const Planes& planes, int width, int height, YcbcrCoding coding) {
  constexpr int careful = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;
  const AvScaler scaler(sws_getContext(width, height, planes.format, width, height, AV_PIX_FMT_RGB24, careful, nullptr,
                                       nullptr, nullptr));
  if (!scaler) throw std::bad_alloc();
  const bool bt709 = coding == YcbcrCoding::bt709_limited || coding == YcbcrCoding::bt709_full;
  const bool full = coding == YcbcrCoding::bt601_full || coding == YcbcrCoding::bt709_full;
  const int* matrix = sws_getCoefficients(bt709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
  constexpr int unity = 1 << 16;
  sws_setColorspaceDetails(scaler.get(), matrix, full, matrix, 1, 0, unity, unity);
  cv::Mat rgb(height, width, CV_8UC3);
  const std::array<std::uint8_t*, 4> out{rgb.data};
  const std::array<int, 4> out_stride{static_cast<int>(rgb.step)};
  sws_scale(scaler.get(), planes.data.data(), planes.stride.data(), 0, height, out.data(), out_stride.data());
  return rgb;
}

Planes planes_of(const Image& image) {
  const std::uint8_t* bytes = image.pixels.get();
  if (image.format == PixelFormat::nv12)
    return {{bytes, bytes + static_cast<std::ptrdiff_t>(image.width) * image.height},
            {image.width, image.width},
            AV_PIX_FMT_NV12};
  const auto format = image.format == PixelFormat::yuyv ? AV_PIX_FMT_YUYV422 : AV_PIX_FMT_UYVY422;
  return {{bytes}, {2 * image.width}, format};
}

// JPEG's full-range formats under the names whose range libswscale lets us set.
AVPixelFormat plain_format(int jpeg_format) {
  switch (jpeg_format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ440P:
      return AV_PIX_FMT_YUV440P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    default:
      return static_cast<AVPixelFormat>(jpeg_format);
  }
}

AvFrame decode_jpeg(const Image& image) {
  keep_av_quiet();
  const AvCodec codec = make_decoder("mjpeg");
  codec->thread_count = 1;
  codec->err_recognition = AV_EF_EXPLODE | AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
  check(avcodec_open2(codec.get(), nullptr, nullptr), "JPEG decoder");
  const AvPacket packet = make_packet();
  check(av_new_packet(packet.get(), static_cast<int>(image.bytes().size())), "JPEG packet");
  std::copy(image.bytes().begin(), image.bytes().end(), packet->data);
  AvFrame picture = make_frame();
  int result = avcodec_send_packet(codec.get(), packet.get());
  if (result >= 0) result = avcodec_receive_frame(codec.get(), picture.get());
  if (result < 0) throw CorruptData("damaged JPEG: " + av_error_text(result));
  if ((picture->flags & AV_FRAME_FLAG_CORRUPT) != 0 || picture->decode_error_flags != 0)
    throw CorruptData("damaged JPEG: the decoder could only guess parts of it");
  return picture;
}

constexpr std::uint8_t kMarker = 0xFF, kStart = 0xD8, kEnd = 0xD9, kScan = 0xDA;

bool is_frame_header(std::uint8_t marker) {  // SOF0 to SOF15 without DHT, JPG and DAC
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

unsigned word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<unsigned>(bytes[at]) << 8U | bytes[at + 1];
}

// Walks the segments from the first to the scan; ITU-T T.81, B.1 and B.2.
std::string header_flaw(std::span<const std::uint8_t> bytes, int width, int height) {
  constexpr std::size_t size_at = 5;  // in a frame header: marker, length, precision, then lines and samples a line
  bool sized = false;
  for (std::size_t at = 2; at + 4 <= bytes.size() && bytes[at] == kMarker;) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == kMarker) {  // fill byte
      ++at;
      continue;
    }
    if (marker == kScan) return sized ? "" : "damaged JPEG: it has no frame header";
    if (is_frame_header(marker)) {
      if (at + size_at + 4 > bytes.size()) break;
      const auto lines = static_cast<int>(word(bytes, at + size_at));
      const auto across = static_cast<int>(word(bytes, at + size_at + 2));
      if (across != width || lines != height)
        return fmt::format("damaged JPEG: it says {} x {} where {} x {} was agreed", across, lines, width, height);
      sized = true;
    }
    at += 2 + word(bytes, at + 2);
  }
  return "damaged JPEG: its header is broken";
}

}  // namespace

cv::Mat ycbcr_to_rgb(const Image& image) {
  return converted(planes_of(image), image.width, image.height, image.ycbcr);
}

cv::Mat jpeg_to_rgb(const Image& image) {
  if (const auto flaw = jpeg_flaw(image.bytes(), image.width, image.height); !flaw.empty()) throw CorruptData(flaw);
  const AvFrame picture = decode_jpeg(image);
  if (picture->width != image.width || picture->height != image.height)
    throw CorruptData(fmt::format("damaged JPEG: it holds {} x {} pixels where {} x {} was agreed", picture->width,
                                  picture->height, image.width, image.height));
  Planes planes{{}, {}, plain_format(picture->format)};
  if (sws_isSupportedInput(planes.format) == 0) throw CorruptData("damaged JPEG: its colours are of an unknown kind");
  std::copy_n(picture->data, planes.data.size(), planes.data.begin());
  std::copy_n(picture->linesize, planes.stride.size(), planes.stride.begin());
  return converted(planes, image.width, image.height, YcbcrCoding::bt601_full);
}

std::string jpeg_flaw(std::span<const std::uint8_t> bytes, int width, int height) {
  while (!bytes.empty() && bytes.back() == 0) bytes = bytes.first(bytes.size() - 1);
  if (bytes.size() < 4 || bytes[0] != kMarker || bytes[1] != kStart) return "damaged JPEG: it has no beginning";
  if (bytes[bytes.size() - 2] != kMarker || bytes.back() != kEnd) return "damaged JPEG: cut short";
  return header_flaw(bytes, width, height);
}

}  // namespace rotunda::capture
