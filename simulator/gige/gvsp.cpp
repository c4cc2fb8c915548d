#include "simulator/gige/gvsp.h"

#include <algorithm>

#include "config/errors.h"
#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

enum class Format : std::uint8_t { leader = 1, trailer = 2, payload = 3, unknown = 0x77 };
constexpr std::uint16_t kImage = 1, kWithChunks = 0x4000;  // payload types
constexpr std::uint32_t kExtendedIds = 1U << 31;
constexpr std::uint32_t kChunkLayout = 1;  // the one layout there is: it follows from what is enabled

struct PacketId {
  bool extended = false;
  std::uint64_t block = 0;
  std::uint32_t packet = 0;
};

GvspPacket with_header(GvspStatus status, const PacketId& id, Format format) {
  GvspPacket out;
  const std::span head{out.head};
  const auto kind = static_cast<std::uint32_t>(format) << 24;
  store_be(head, 0, static_cast<std::uint16_t>(status));
  if (!id.extended) {
    store_be(head, 2, static_cast<std::uint16_t>(id.block));
    store_be(head, 4, kind | (id.packet & 0x00FFFFFF));
    out.head_bytes = 8;
    return out;
  }
  store_be(head, 4, kExtendedIds | kind);
  store_be(head, 8, id.block);
  store_be(head, 16, id.packet);
  out.head_bytes = 20;
  return out;
}

std::uint16_t payload_type(const GvspFrame& frame) {
  return frame.chunks.empty() ? kImage : static_cast<std::uint16_t>(kImage | kWithChunks);
}

void add_leader(GvspPacket& packet, const GvspFrame& frame) {
  const std::span head = std::span{packet.head}.subspan(packet.head_bytes);
  store_be(head, 2, payload_type(frame));
  store_be(head, 4, static_cast<std::uint64_t>(frame.exposure_start.time_since_epoch().count()));
  store_be(head, 12, frame.pixel_code);
  store_be(head, 16, frame.width);
  store_be(head, 20, frame.height);
  store_be(head, 24, frame.offset_x);
  store_be(head, 28, frame.offset_y);
  packet.head_bytes += 36;  // the paddings, bytes 32 to 35, are 0
}

void add_trailer(GvspPacket& packet, const GvspFrame& frame) {
  const std::span head = std::span{packet.head}.subspan(packet.head_bytes);
  store_be(head, 2, payload_type(frame));
  store_be(head, 4, frame.height);
  packet.head_bytes += 8;
  if (frame.chunks.empty()) return;
  store_be(head, 8, static_cast<std::uint32_t>(frame.pixels.size() + frame.chunks.size()));
  store_be(head, 12, kChunkLayout);
  packet.head_bytes += 8;
}

// Pixels, then chunks, as if they were one.
void add_payload(GvspPacket& packet, const GvspFrame& frame, std::size_t begin, std::size_t bytes) {
  const std::size_t pixels = frame.pixels.size();
  const std::size_t of_pixels = begin < pixels ? std::min(bytes, pixels - begin) : 0;
  if (of_pixels > 0) packet.pixels = frame.pixels.subspan(begin, of_pixels);
  if (begin + of_pixels < pixels) return;
  const std::size_t first = begin + of_pixels - pixels;
  packet.chunks = std::span{frame.chunks}.subspan(first, std::min(bytes - of_pixels, frame.chunks.size() - first));
}

std::size_t payload_per_packet(const GvspFrame& frame) {
  return frame.packet_size - (frame.extended_ids ? kGvspExtendedOverhead : kGvspOverhead);
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
    case capture::PixelFormat::bayer_rg12p:
      return 0x010C0059;
    default:
      throw InvalidInput("the simulated cameras do not send " + std::string(capture::to_string(format)));
  }
}

// PFNC: bits 16 to 23 of a code are the bits a pixel takes.
std::uint32_t bits_per_pixel(std::uint32_t pixel_code) {
  return (pixel_code >> 16) & 0xFF;
}

std::size_t picture_bytes(std::uint32_t pixel_code, std::uint32_t width, std::uint32_t height) {
  return (static_cast<std::size_t>(width) * height * bits_per_pixel(pixel_code) + 7) / 8;
}

std::size_t gvsp_header_bytes(const GvspFrame& frame) {
  return frame.extended_ids ? 20 : 8;
}

std::uint32_t packet_count(const GvspFrame& frame) {
  const std::size_t size = payload_per_packet(frame);
  return static_cast<std::uint32_t>((frame.pixels.size() + frame.chunks.size() + size - 1) / size + 2);
}

GvspPacket gvsp_packet(const GvspFrame& frame, std::uint32_t packet, GvspStatus status) {
  const bool is_trailer = packet + 1 == packet_count(frame);
  const Format format = packet == 0 ? Format::leader : is_trailer ? Format::trailer : Format::payload;
  GvspPacket out = with_header(status, {frame.extended_ids, frame.block, packet}, format);
  if (format == Format::leader) {
    add_leader(out, frame);
  } else if (format == Format::trailer) {
    add_trailer(out, frame);
  } else {
    add_payload(out, frame, (packet - 1) * payload_per_packet(frame), payload_per_packet(frame));
  }
  return out;
}

GvspPacket gvsp_stray(const GvspFrame& frame) {
  return with_header(GvspStatus::ok, {frame.extended_ids, frame.block, 0}, Format::unknown);
}

GvspPacket gvsp_unavailable(const ResendCommand& request) {
  return with_header(GvspStatus::unavailable, {request.extended_ids, request.block, request.first}, Format::payload);
}

}  // namespace rotunda::simulator
