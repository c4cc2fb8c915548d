#pragma once
// GigE Vision Stream Protocol: one frame as a leader, payload packets and a trailer. Pure; all fields big-endian
// (GigE Vision 2.x, GVSP). Header with standard ids, 8 bytes: u16 status, u16 block id, u8 format, u24 packet id; with
// extended ids, 20 bytes: u16 status, u16 flags, u8 format with bit 7 set, u24 0, u64 block id, u32 packet id.
// Packet 0 is the leader, packet packet_count() - 1 the trailer; what lies between carries the pixels, then the chunks.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "capture/frame.h"
#include "simulator/gige/gvcp.h"

namespace rotunda::simulator {

// What the packet size register counts beside the payload: IP 20 + UDP 8 + GVSP header.
inline constexpr std::uint32_t kGvspOverhead = 36, kGvspExtendedOverhead = 48;
inline constexpr std::uint32_t kMinPacketSize = 576, kMaxPacketSize = 16404;

enum class GvspStatus : std::uint16_t { ok = 0x0000, resent = 0x0100, unavailable = 0x800C };

struct GvspFrame {
  std::uint64_t block = 1;  // from 1; standard ids end at 65535 and skip 0
  bool extended_ids = false;
  capture::Timestamp exposure_start;  // by the camera's clock
  std::uint32_t pixel_code = 0;       // PFNC: 0x01080009 is BayerRG8
  std::uint32_t width = 0, height = 0, offset_x = 0, offset_y = 0;
  std::uint32_t packet_size = 1500;      // bytes with IP, UDP and GVSP headers
  std::span<const std::uint8_t> pixels;  // lent, or of own_pixels
  std::vector<std::uint8_t> own_pixels;
  std::vector<std::uint8_t> chunks;  // of chunk_data.h; empty: no chunk mode
};

// One packet: the bytes made here, and the parts of the frame's pixels and chunks that follow them on the wire.
struct GvspPacket {
  std::array<std::uint8_t, 56> head{};
  std::size_t head_bytes = 0;
  std::span<const std::uint8_t> pixels, chunks;
};

std::uint32_t pixel_code(capture::PixelFormat format);  // Pixel Format Naming Convention
std::uint32_t bits_per_pixel(std::uint32_t pixel_code);
std::size_t picture_bytes(std::uint32_t pixel_code, std::uint32_t width, std::uint32_t height);
std::size_t gvsp_header_bytes(const GvspFrame& frame);  // of each packet: 8 or 20
std::uint32_t packet_count(const GvspFrame& frame);     // leader and trailer included
// `packet` < packet_count(frame).
GvspPacket gvsp_packet(const GvspFrame& frame, std::uint32_t packet, GvspStatus status = GvspStatus::ok);
// A packet of a format that no stream knows, with the frame's block id.
GvspPacket gvsp_stray(const GvspFrame& frame);
// The answer to a resend request for what is no longer kept.
GvspPacket gvsp_unavailable(const ResendCommand& request);

}  // namespace rotunda::simulator
