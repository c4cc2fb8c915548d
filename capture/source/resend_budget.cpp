#include "capture/source/resend_budget.h"

namespace rotunda::capture {
namespace {

constexpr std::uint64_t kEnough = 1000;  // a second of a PAL camera in packets of 8900 bytes

}  // namespace

bool ResendBudget::look(std::uint64_t packets, std::uint64_t asked_again) {
  const std::uint64_t due = packets > packets_ ? packets - packets_ : 0;
  const std::uint64_t again = asked_again > asked_again_ ? asked_again - asked_again_ : 0;
  const bool anew = packets < packets_;
  if (due < kEnough && !anew) return true;
  packets_ = packets;
  asked_again_ = asked_again;
  share_ = anew ? 0.0 : static_cast<double>(again) / static_cast<double>(due);
  return share_ <= budget_;
}

}  // namespace rotunda::capture
