#include "capture/source/resend_budget.h"

namespace rotunda::capture {

bool ResendBudget::look(std::uint64_t packets, std::uint64_t asked_again) {
  const std::uint64_t due = packets > packets_ ? packets - packets_ : 0;
  const std::uint64_t again = asked_again > asked_again_ ? asked_again - asked_again_ : 0;
  packets_ = packets;
  asked_again_ = asked_again;
  share_ = due > 0 ? static_cast<double>(again) / static_cast<double>(due) : 0.0;
  return share_ <= budget_;
}

}  // namespace rotunda::capture
