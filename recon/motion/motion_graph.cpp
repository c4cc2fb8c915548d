#include "recon/motion/motion_graph.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <deque>
#include <map>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

template <class T>
const T& named(const std::vector<T>& all, const std::string& name, const char* what) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const T& one) { return one.name == name; });
  if (found != all.end()) return *found;
  std::vector<std::string> names;
  for (const T& one : all) names.push_back(one.name);
  throw InvalidInput(fmt::format("there is no {} \"{}\"; there are: {}", what, name, fmt::join(names, ", ")));
}

}  // namespace

const MotionClip& MotionGraph::clip(const std::string& wanted) const {
  return named(clips, wanted, "clip");
}

const MotionState& MotionGraph::state(const std::string& wanted) const {
  return named(states, wanted, "state");
}

// Breadth first, so by the fewest transitions; captured ones before synthesised ones.
const MotionTransition* MotionGraph::next_towards(const std::string& from, const std::string& to) const {
  std::vector<const MotionTransition*> ordered;
  for (const auto& transition : transitions)
    if (transition.from != transition.to) ordered.push_back(&transition);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const auto* a, const auto* b) { return a->synthesised() < b->synthesised(); });
  std::map<std::string, const MotionTransition*> first{{from, nullptr}};
  std::deque<std::string> open{from};
  while (!open.empty()) {
    const std::string at = open.front();
    open.pop_front();
    if (at == to) return first.at(at);
    for (const auto* transition : ordered)
      if (transition->from == at && first.count(transition->to) == 0) {
        first[transition->to] = first.at(at) == nullptr ? transition : first.at(at);
        open.push_back(transition->to);
      }
  }
  return nullptr;
}

}  // namespace rotunda::recon
