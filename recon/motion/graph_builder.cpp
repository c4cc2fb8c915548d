#include "recon/motion/graph_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

enum class Kind { state, transition, action };

struct Role {
  Kind kind = Kind::state;
  std::string from, to;
};

class Builder {
 public:
  Builder(const std::vector<MovingClip>& clips, const std::string& name, int blend) : clips_(clips), blend_(blend) {
    built_.graph.name = name;
    built_.graph.fps = clips.front().shape.fps;
  }

  BuiltGraph build() {
    for (const auto& clip : clips_) add_clip(clip);
    find_roles();
    for (const auto& clip : clips_)
      if (roles_.at(clip.shape.name).kind != Kind::state) add_transition(clip, roles_.at(clip.shape.name));
    choose_start();
    synthesise();
    return std::move(built_);
  }

 private:
  const MovingClip& clip_named(const std::string& name) const {
    return *std::find_if(clips_.begin(), clips_.end(), [&](const auto& clip) { return clip.shape.name == name; });
  }
  bool has_clip(const std::string& name) const {
    return std::any_of(clips_.begin(), clips_.end(), [&](const auto& clip) { return clip.shape.name == name; });
  }

  void add_clip(const MovingClip& clip) {
    built_.graph.clips.push_back({.name = clip.shape.name,
                                  .take = "",
                                  .frames = clip.shape.frame_count(),
                                  .heading = clip.events.heading,
                                  .speed = clip.events.speed,
                                  .strikes = clip.events.strikes,
                                  .contacts = clip.events.contacts});
  }

  // "walk-jog" where there are clips walk and jog.
  std::optional<Role> named_transition(const std::string& name) const {
    for (auto dash = name.find('-'); dash != std::string::npos; dash = name.find('-', dash + 1)) {
      const auto from = name.substr(0, dash), to = name.substr(dash + 1);
      if (has_clip(from) && has_clip(to)) return Role{Kind::transition, from, to};
    }
    return std::nullopt;
  }

  // Who goes is a state. Of those who stand the quietest is; others may begin and end like it: a kick.
  void find_roles() {
    std::vector<const MovingClip*> standing;
    for (const auto& clip : clips_) {
      if (const auto role = named_transition(clip.shape.name)) {
        roles_[clip.shape.name] = *role;
      } else if (clip.events.speed > 0.0) {
        add_state(clip);
      } else {
        standing.push_back(&clip);
      }
    }
    std::stable_sort(standing.begin(), standing.end(),
                     [](const auto* a, const auto* b) { return a->median_step < b->median_step; });
    for (const auto* clip : standing)
      if (!add_action(*clip)) add_state(*clip);
    if (built_.graph.states.empty())
      throw InvalidInput("no take goes on as a cycle; a character needs at least one state, such as idle or walk");
  }

  void add_state(const MovingClip& clip) {
    const auto found = find_cycle(clip, blend_);
    if (!found.loop) throw InvalidInput(found.failure);
    roles_[clip.shape.name] = {Kind::state, "", ""};
    built_.graph.states.push_back({clip.shape.name, clip.shape.name, *found.loop});
  }

  JoinRange cycle_of(const MotionState& state) const { return {state.loop.enter, state.loop.leave, 0, 0}; }

  std::vector<Join> leaves(const MotionState& state, const MovingClip& clip) const {
    auto range = cycle_of(state);
    range.enter_end = std::max(1, (clip.shape.frame_count() - 2 * blend_) / 2);
    return find_joins(clip_named(state.clip), clip, range, blend_);
  }

  std::optional<Join> arrival(const MovingClip& clip, const MotionState& state) const {
    const int half = (clip.shape.frame_count() - blend_) / 2;
    auto joins = find_joins(clip, clip_named(state.clip),
                            {half, clip.shape.frame_count(), state.loop.enter, state.loop.leave}, blend_);
    if (joins.empty()) return std::nullopt;
    return best_seam(joins);
  }

  bool add_action(const MovingClip& clip) {
    for (const auto& state : built_.graph.states) {
      auto out = leaves(state, clip);
      const auto back = arrival(clip, state);
      const bool moves = clip.median_step > 2.0 * clip_named(state.clip).median_step;
      if (out.empty() || !back || !moves) continue;
      roles_[clip.shape.name] = {Kind::action, state.name, state.name};
      return true;
    }
    return false;
  }

  void add_transition(const MovingClip& clip, const Role& role) {
    const auto& from = built_.graph.state(role.from);
    const auto& to = built_.graph.state(role.to);
    const auto refuse = [&](const std::string& where, const std::string& state) {
      throw InvalidInput(fmt::format(
          "{} has no pose in common with {} {}: no two of their frames are within 50 mm; record it from the "
          "very motion of {} to that of {}",
          clip.shape.name, state, where, role.from, role.to));
    };
    MotionTransition transition{.name = clip.shape.name,
                                .from = role.from,
                                .to = role.to,
                                .clip = clip.shape.name,
                                .leaves = leaves(from, clip)};
    if (transition.leaves.empty()) refuse("at its beginning", role.from);
    const auto arrive = arrival(clip, to);
    if (!arrive) refuse("at its end", role.to);
    transition.arrive = *arrive;
    built_.graph.transitions.push_back(std::move(transition));
  }

  void choose_start() {
    const auto slowest =
        std::min_element(built_.graph.states.begin(), built_.graph.states.end(), [&](const auto& a, const auto& b) {
          return clip_named(a.clip).events.speed < clip_named(b.clip).events.speed;
        });
    built_.graph.start = slowest->name;
  }

  // Where no way leads from one state to another, they are joined where they are most alike.
  void synthesise() {
    for (const auto& from : built_.graph.states)
      for (const auto& to : built_.graph.states) {
        if (from.name == to.name || built_.graph.next_towards(from.name, to.name) != nullptr) continue;
        auto range = cycle_of(from);
        range.enter_first = to.loop.enter;
        range.enter_end = to.loop.leave;
        MotionTransition transition{.name = from.name + "-" + to.name, .from = from.name, .to = to.name};
        transition.leaves = nearest_joins(clip_named(from.clip), clip_named(to.clip), range, blend_);
        built_.told.push_back(fmt::format("{} was not recorded: synthesised by blending, {:.0f} mm apart at best",
                                          transition.name, best_seam(transition.leaves).price.error_mm));
        built_.graph.transitions.push_back(std::move(transition));
      }
  }

  const std::vector<MovingClip>& clips_;
  const int blend_;
  BuiltGraph built_;
  std::map<std::string, Role> roles_;
};

}  // namespace

BuiltGraph build_graph(const std::vector<MovingClip>& clips, const std::string& name, int blend) {
  if (clips.empty()) throw InvalidInput("a character is made of takes; name at least one");
  return Builder(clips, name, blend).build();
}

}  // namespace rotunda::recon
