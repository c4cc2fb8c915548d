#pragma once
// Line0: the opto-coupled input a trigger box drives. Pure: levels with their times in, accepted edges out.
// With a debouncer an edge counts once the line has kept its new level so long, and at that time.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "capture/frame.h"

namespace rotunda::simulator {

enum class TriggerActivation : std::uint32_t { rising_edge = 0, falling_edge = 1, any_edge = 2 };

struct LineEdge {
  capture::Timestamp at;
  bool rising = true;

  bool fires(TriggerActivation activation) const {
    return activation == TriggerActivation::any_edge || rising == (activation == TriggerActivation::rising_edge);
  }
};

class LineInput {
 public:
  static constexpr std::size_t kMaxEdges = 64;  // told and not yet taken; more are lost

  // Times ascend; a level it has already is no edge.
  void set(bool high, capture::Timestamp at);
  // Edges accepted up to `now`, in order.
  std::optional<LineEdge> take_edge(capture::Timestamp now, std::chrono::nanoseconds debounce);
  std::optional<capture::Timestamp> next_edge(std::chrono::nanoseconds debounce) const;
  bool is_high(capture::Timestamp at) const;  // at the terminals, before the debouncer

 private:
  std::deque<LineEdge> edges_;    // not yet accepted
  std::deque<LineEdge> history_;  // the last ones, for is_high()
};

}  // namespace rotunda::simulator
