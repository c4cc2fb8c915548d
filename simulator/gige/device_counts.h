#pragma once
// What one simulated camera has heard and done since it was made.
#include <cstdint>

#include "simulator/gige/faults.h"

namespace rotunda::simulator {

struct DeviceCounts {
  std::uint64_t triggers = 0;          // accepted, of any kind; free run does not count
  std::uint64_t ignored_triggers = 0;  // not armed, or during an exposure
  std::uint64_t late_actions = 0;
  std::uint64_t resend_requests = 0;
  std::uint64_t denied = 0;            // commands refused with 0x8006
  std::uint64_t lost_controllers = 0;  // heartbeats that stopped
  std::uint64_t pending_acks = 0;      // commands told to take long
  FaultCounts faults;
};

}  // namespace rotunda::simulator
