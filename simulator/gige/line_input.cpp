#include "simulator/gige/line_input.h"

namespace rotunda::simulator {

void LineInput::set(bool high, capture::Timestamp at) {
  const bool was_high = !history_.empty() && history_.back().rising;
  if (high == was_high || edges_.size() >= kMaxEdges) return;
  edges_.push_back({at, high});
  history_.push_back({at, high});
  if (history_.size() > kMaxEdges) history_.pop_front();
}

std::optional<LineEdge> LineInput::take_edge(capture::Timestamp now, std::chrono::nanoseconds debounce) {
  // A level given up before its time was a bounce: it and its end never were.
  while (edges_.size() > 1 && edges_[1].at - edges_[0].at < debounce) edges_.erase(edges_.begin(), edges_.begin() + 2);
  if (edges_.empty() || edges_.front().at + debounce > now) return std::nullopt;
  LineEdge edge = edges_.front();
  edges_.pop_front();
  edge.at += debounce;
  return edge;
}

std::optional<capture::Timestamp> LineInput::next_edge(std::chrono::nanoseconds debounce) const {
  if (edges_.empty()) return std::nullopt;
  return edges_.front().at + debounce;
}

bool LineInput::is_high(capture::Timestamp at) const {
  for (auto edge = history_.rbegin(); edge != history_.rend(); ++edge)
    if (edge->at <= at) return edge->rising;
  return !history_.empty() && !history_.front().rising;
}

}  // namespace rotunda::simulator
