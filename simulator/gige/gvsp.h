#pragma once
// GigE Vision Stream Protocol: one frame as a leader, payload packets and a trailer. Pure; all fields big-endian
// (GigE Vision 2.x, GVSP, 16-bit block ids). Header, 8 bytes: u16 status, u16 block id, u8 format, u24 packet id.
// Packet 0 is the leader, packet packet_count() - 1 the trailer; what lies between carries the pixels in order.
#include <array>
#include <cstdint>
#include <span>

#include "capture/frame.h"

namespace rotunda::simulator {

inline constexpr std::uint32_t kGvspOverhead = 36;  // IP 20 + UDP 8 + GVSP 8: what the packet size register counts
inline constexpr std::uint32_t kMinPacketSize = 576, kMaxPacketSize = 16404;

enum class GvspStatus : std::uint16_t { ok = 0x0000, resent = 0x0100, unavailable = 0x800C };

struct GvspFrame {
  std::uint16_t block = 1;  // 1 to 65535; 0 is skipped
  capture::Timestamp exposure_start;
  std::uint32_t pixel_code = 0;  // PFNC: 0x01080009 is BayerRG8
  std::uint32_t width = 0, height = 0;
  std::uint32_t packet_size = 1500;      // bytes with IP, UDP and GVSP headers
  std::span<const std::uint8_t> pixels;  // lent
};

// One packet: the bytes made here, and the part of the frame's pixels that follows them on the wire.
struct GvspPacket {
  std::array<std::uint8_t, 44> head{};
  std::size_t head_bytes = 0;
  std::span<const std::uint8_t> pixels;
};

std::uint32_t pixel_code(capture::PixelFormat format);  // Pixel Format Naming Convention
std::uint32_t packet_count(const GvspFrame& frame);     // leader and trailer included
// `packet` < packet_count(frame).
GvspPacket gvsp_packet(const GvspFrame& frame, std::uint32_t packet, GvspStatus status = GvspStatus::ok);
// The answer to a resend request for what is no longer kept.
GvspPacket gvsp_unavailable(std::uint16_t block, std::uint32_t packet);

}  // namespace rotunda::simulator
