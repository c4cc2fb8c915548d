#include "rig/cli/frame_range.h"

#include <charconv>
#include <limits>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

std::size_t number(const std::string& text, std::size_t begin, std::size_t end, std::size_t if_empty) {
  if (begin == end) return if_empty;
  std::size_t value = 0;
  const auto result = std::from_chars(text.data() + begin, text.data() + end, value);
  if (result.ec != std::errc{} || result.ptr != text.data() + end)
    throw InvalidInput("\"" + text + "\" is no range of frames; write A:B, half-open, counted from 0, such as 0:25");
  return value;
}

}  // namespace

std::pair<std::size_t, std::size_t> frame_range(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) {
    const auto frame = number(text, 0, text.size(), 0);
    return {frame, frame + 1};
  }
  const auto range = std::pair(number(text, 0, colon, 0),
                               number(text, colon + 1, text.size(), std::numeric_limits<std::size_t>::max()));
  if (range.first >= range.second) throw InvalidInput("the range \"" + text + "\" holds no frame");
  return range;
}

}  // namespace rotunda::rig
