#include "capture/sync/exposure_ledger.h"

#include <iterator>

namespace rotunda::capture {
namespace {

// Frames remembered: more than can wait for their sets, few enough to look through.
constexpr std::size_t kRemembered = 512;

}  // namespace

void ExposureLedger::came(std::uint64_t id) {
  if (!came_.empty() && id + kRemembered < *came_.rbegin()) came_.clear();  // the camera counts from its start again
  came_.insert(id);
  if (came_.size() > kRemembered) came_.erase(came_.begin());
}

void ExposureLedger::left_with(const Frame& frame) {
  announced_ = 0;
  last_ = frame.id ? std::optional<Place>({frame.trigger, *frame.id}) : std::nullopt;
}

void ExposureLedger::left_without(bool announced) {
  if (announced) ++announced_;
}

HoleReason ExposureLedger::reason(const std::optional<Place>& next, std::uint64_t announced) const {
  if (!last_ || !next || next->id <= last_->id || next->trigger <= last_->trigger) return HoleReason::late;
  const std::uint64_t told = announced_ + announced;
  const std::uint64_t untold_holes = next->trigger - last_->trigger - 1 - told;
  const auto strays =
      static_cast<std::uint64_t>(std::distance(came_.upper_bound(last_->id), came_.lower_bound(next->id)));
  const std::uint64_t exposed = next->id - last_->id - 1;
  if (exposed <= strays + told) return HoleReason::trigger_missed;
  return exposed - strays - told >= untold_holes ? HoleReason::packets_lost : HoleReason::late;
}

}  // namespace rotunda::capture
