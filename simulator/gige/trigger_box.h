#pragma once
// What the simulated trigger box says to the cameras that hang on its line: one datagram an edge, 16 bytes, big-endian:
// "RTBX", u8 level (0 low, 1 high), 3 bytes 0, u64 time of the edge in ns TAI (0: when it is received). Pure.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

struct LineLevel {
  bool high = false;
  std::optional<capture::Timestamp> at;
};

std::vector<std::uint8_t> line_datagram(const LineLevel& level);
// Nothing for any other bytes.
std::optional<LineLevel> parse_line(std::span<const std::uint8_t> datagram);

}  // namespace rotunda::simulator
