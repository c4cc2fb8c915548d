#include "capture/source/exposure_counter.h"

#include <algorithm>

namespace rotunda::capture {
namespace {

constexpr std::uint64_t kRound = 65535;  // 16-bit ids skip 0

}  // namespace

std::optional<std::uint64_t> ExposureCounter::count(std::uint64_t block_id) {
  if (block_id == 0) return std::nullopt;
  std::uint64_t unwrapped = block_id;
  if (block_id <= kRound) {
    const std::uint64_t rounds = latest_ / kRound;
    unwrapped += rounds * kRound;
    if (unwrapped + kRound / 2 < latest_)
      unwrapped += kRound;
    else if (rounds > 0 && unwrapped > latest_ + kRound / 2)
      unwrapped -= kRound;
  }
  latest_ = std::max(latest_, unwrapped);
  return unwrapped;
}

}  // namespace rotunda::capture
