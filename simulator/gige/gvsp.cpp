#include "simulator/gige/gvsp.h"

#include <algorithm>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

enum class Format : std::uint8_t { leader = 1, trailer = 2, payload = 3 };
constexpr std::uint16_t kImage = 1;  // payload type

GvspPacket with_header(GvspStatus status, std::uint16_t block, Format format, std::uint32_t packet) {
  GvspPacket out;
  store_be(std::span{out.head}, 0, static_cast<std::uint16_t>(status));
  store_be(std::span{out.head}, 2, block);
  store_be(std::span{out.head}, 4, static_cast<std::uint32_t>(format) << 24 | (packet & 0x00FFFFFF));
  out.head_bytes = 8;
  return out;
}

void add_leader(GvspPacket& packet, const GvspFrame& frame) {
  const std::span head{packet.head};
  store_be(head, 10, kImage);
  store_be(head, 12, static_cast<std::uint64_t>(frame.exposure_start.time_since_epoch().count()));
  store_be(head, 20, frame.pixel_code);
  store_be(head, 24, frame.width);
  store_be(head, 28, frame.height);
  packet.head_bytes = 44;  // offsets and paddings, bytes 32 to 43, are 0
}

void add_trailer(GvspPacket& packet, const GvspFrame& frame) {
  store_be(std::span{packet.head}, 10, kImage);
  store_be(std::span{packet.head}, 12, frame.height);
  packet.head_bytes = 16;
}

std::size_t pixels_per_packet(const GvspFrame& frame) {
  return frame.packet_size - kGvspOverhead;
}

}  // namespace

std::uint32_t pixel_code(capture::PixelFormat format) {
  switch (format) {
    case capture::PixelFormat::mono8:
      return 0x01080001;
    case capture::PixelFormat::bayer_gr8:
      return 0x01080008;
    case capture::PixelFormat::bayer_rg8:
      return 0x01080009;
    case capture::PixelFormat::bayer_gb8:
      return 0x0108000A;
    case capture::PixelFormat::bayer_bg8:
      return 0x0108000B;
    case capture::PixelFormat::rgb8:
      return 0x02180014;
  }
  return 0;
}

std::uint32_t packet_count(const GvspFrame& frame) {
  const std::size_t size = pixels_per_packet(frame);
  return static_cast<std::uint32_t>((frame.pixels.size() + size - 1) / size + 2);
}

GvspPacket gvsp_packet(const GvspFrame& frame, std::uint32_t packet, GvspStatus status) {
  const bool is_trailer = packet + 1 == packet_count(frame);
  const Format format = packet == 0 ? Format::leader : is_trailer ? Format::trailer : Format::payload;
  GvspPacket out = with_header(status, frame.block, format, packet);
  if (format == Format::leader) {
    add_leader(out, frame);
  } else if (format == Format::trailer) {
    add_trailer(out, frame);
  } else {
    const std::size_t begin = (packet - 1) * pixels_per_packet(frame);
    out.pixels = frame.pixels.subspan(begin, std::min(pixels_per_packet(frame), frame.pixels.size() - begin));
  }
  return out;
}

GvspPacket gvsp_unavailable(std::uint16_t block, std::uint32_t packet) {
  return with_header(GvspStatus::unavailable, block, Format::payload, packet);
}

}  // namespace rotunda::simulator
