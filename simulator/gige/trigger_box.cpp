#include "simulator/gige/trigger_box.h"

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

constexpr std::size_t kBytes = 16;
constexpr std::uint32_t kMark = 0x52544258;  // "RTBX"

}  // namespace

std::vector<std::uint8_t> line_datagram(const LineLevel& level) {
  std::vector<std::uint8_t> datagram(kBytes);
  store_be(std::span{datagram}, 0, kMark);
  datagram[4] = level.high ? 1 : 0;
  if (level.at) store_be(std::span{datagram}, 8, static_cast<std::uint64_t>(level.at->time_since_epoch().count()));
  return datagram;
}

std::optional<LineLevel> parse_line(std::span<const std::uint8_t> datagram) {
  if (datagram.size() != kBytes || load_be<std::uint32_t>(datagram, 0) != kMark || datagram[4] > 1) return std::nullopt;
  LineLevel level{.high = datagram[4] == 1, .at = {}};
  const auto at = load_be<std::uint64_t>(datagram, 8);
  if (at > INT64_MAX / 2) return std::nullopt;  // no time we could count on from
  if (at != 0) level.at = capture::Timestamp{std::chrono::nanoseconds{static_cast<std::int64_t>(at)}};
  return level;
}

}  // namespace rotunda::simulator
