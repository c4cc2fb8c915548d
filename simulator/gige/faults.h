#pragma once
// What may go wrong with a simulated camera; set at run time. Loss is a function of the seed, the packet and how
// often it was sent, so a run can be repeated.
#include <chrono>
#include <cstdint>

namespace rotunda::simulator {

struct GigeFaults {
  double packet_loss = 0.0;         // share of stream packets that never leave, resent ones included; 0 to 1
  std::uint64_t seed = 1;           // of the loss
  bool silent = false;              // link loss: hears nothing, sends nothing
  std::chrono::nanoseconds late{};  // frames leave this much later than they should
};

// Whether this sending of this packet gets lost. `attempt` counts from 0.
bool is_lost(const GigeFaults& faults, std::size_t camera, std::uint16_t block, std::uint32_t packet,
             std::uint64_t attempt);

}  // namespace rotunda::simulator
