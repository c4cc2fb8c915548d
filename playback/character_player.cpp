#include "playback/character_player.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/errors.h"

namespace rotunda::playback {
namespace {

using recon::FloorPose;

constexpr double kTurnRate = 0.5 * std::numbers::pi;  // radians a second
constexpr double kSlowest = 0.6, kFastest = 1.5;      // of the recording: beyond it looks like film, not like people
constexpr double kStands = 0.2;                       // m/s: who is asked for less is to stand
constexpr std::size_t kMostTracks = 3;
constexpr double kShareRate = 2.5;  // a second, by which another gait's share grows or shrinks

}  // namespace

CharacterPlayer::CharacterPlayer(recon::MotionGraph graph, RootPaths roots)
    : graph_(std::move(graph)), roots_(std::move(roots)) {
  if (roots_.size() != graph_.clips.size()) throw InvalidInput("a character needs the roots of all its clips");
  for (std::size_t i = 0; i < roots_.size(); ++i)
    if (static_cast<int>(roots_[i].size()) != graph_.clips[i].frames)
      throw InvalidInput("clip " + graph_.clips[i].name + " has not as many roots as frames");
  state_ = &graph_.state(graph_.start);
  doing_ = wanted_ = graph_.start;
  const std::size_t clip = index_of(state_->clip);
  const auto& root = roots_[clip][static_cast<std::size_t>(state_->loop.enter)];
  const double heading = graph_.clips[clip].heading;
  const Eigen::Vector2d turned = FloorPose{0.0, 0.0, -heading} * root;
  strand_.emplace(clip, static_cast<double>(state_->loop.enter), FloorPose{-turned.x(), -turned.y(), -heading});
}

std::size_t CharacterPlayer::index_of(const std::string& clip) const {
  return static_cast<std::size_t>(&graph_.clip(clip) - graph_.clips.data());
}

void CharacterPlayer::command(const Command& command) {
  if (command.state) {
    const auto action = std::find_if(graph_.transitions.begin(), graph_.transitions.end(),
                                     [&](const auto& t) { return t.from == t.to && t.name == *command.state; });
    action_ = action == graph_.transitions.end() ? nullptr : &*action;
    wanted_ = action_ ? action_->to : graph_.state(*command.state).name;
    speed_.reset();
  }
  if (command.speed) {
    speed_ = *command.speed;
    const auto fit = [&](const recon::MotionState& state) {
      const double own = graph_.clip(state.clip).speed;
      if (own == 0.0 || *speed_ < kStands) return own == 0.0 && *speed_ < kStands ? 0.0 : 1e6 + own;
      return std::abs(std::log(*speed_ / own));
    };
    wanted_ = std::min_element(graph_.states.begin(), graph_.states.end(), [&](const auto& a, const auto& b) {
                return fit(a) < fit(b);
              })->name;
  }
  if (command.turn) turn_left_ += *command.turn;
  if (command.heading) turn_left_ += std::remainder(*command.heading - aim(), 2.0 * std::numbers::pi);
}

double CharacterPlayer::aim() const {
  const auto& now = strand_->now();
  return now.world_from_clip.yaw + graph_.clips[now.clip].heading + turn_left_;
}

double CharacterPlayer::rate() const {
  if (companion_) return pace_of(*state_).seconds / stride_seconds();
  if (!speed_ || transition_ != nullptr || state_->name != wanted_) return 1.0;
  const double own = graph_.clip(state_->clip).speed;
  return own > 0.0 ? std::clamp(*speed_ / own, kSlowest, kFastest) : 1.0;
}

const recon::MotionTransition* CharacterPlayer::wanted_transition() const {
  const std::string& target = action_ ? action_->from : wanted_;
  if (action_ && state_->name == target) return action_;
  return state_->name == target ? nullptr : graph_.next_towards(state_->name, target);
}

// The next place where another clip takes over: out of a transition its arrival, out of a state the earliest way
// towards what is wanted, else the cycle's own seam.
CharacterPlayer::Seam CharacterPlayer::next_seam() const {
  if (transition_ != nullptr && !transition_->synthesised()) {
    const auto& to = graph_.state(transition_->to);
    return {&transition_->arrive, to.clip, nullptr, &to};
  }
  const auto& now = strand_->now();
  Seam seam{&state_->loop, state_->clip, nullptr, state_};
  const auto* transition = wanted_transition();
  if (transition == nullptr || companion_ || strand_->track_count() >= kMostTracks) return seam;
  for (const auto& leave : transition->leaves) {
    if (leave.leave <= now.frame + 1e-9 || leave.leave > state_->loop.leave) continue;
    const auto& to = graph_.state(transition->to);
    if (transition->synthesised()) return {&leave, to.clip, nullptr, &to};
    return {&leave, transition->clip, transition, nullptr};
  }
  return seam;
}

void CharacterPlayer::pass(const Seam& seam) {
  strand_->pass(*seam.join, index_of(seam.clip));
  if (seam.begins) {
    if (seam.begins == action_) action_ = nullptr;
    transition_ = seam.begins;
    doing_ = seam.begins->name;
    ++seams_;
  } else {
    if (transition_ != nullptr || seam.arrives != state_) ++seams_;
    transition_ = nullptr;
    state_ = seam.arrives;
    doing_ = state_->name;
  }
}

void CharacterPlayer::play(double frames) {
  while (frames > 0.0) {
    const Seam seam = next_seam();
    const double way = std::max(0.0, seam.join->leave - strand_->now().frame);
    if (frames + 1e-9 < way) return strand_->move(frames);
    strand_->move(way);
    frames -= way;
    pass(seam);
    if (frames < 1e-9) return;
  }
}

void CharacterPlayer::advance(double seconds) {
  const double frames = seconds * graph_.fps * rate();
  lead_companion(seconds);
  turn(seconds);
  const Eigen::Vector2d before = place(*strand_);
  play(frames);
  if (!companion_) return;
  // Both go the way that they go together.
  const Eigen::Vector2d before_there = place(companion_->strand), way = place(*strand_) - before;
  keep_phase();
  const Eigen::Vector2d way_there = place(companion_->strand) - before_there;
  const Eigen::Vector2d together = (1.0 - companion_->share) * way + companion_->share * way_there;
  strand_->lay({together.x() - way.x(), together.y() - way.y(), 0.0});
  companion_->strand.lay({together.x() - way_there.x(), together.y() - way_there.y(), 0.0});
}

StridePace CharacterPlayer::pace_of(const recon::MotionState& state) const {
  return {state.period() / graph_.fps, graph_.clip(state.clip).speed};
}

// The gait on the other side of the speed asked for, if strides of both can be told.
const recon::MotionState* CharacterPlayer::wanted_companion() const {
  if (!speed_ || transition_ != nullptr || state_->name != wanted_ || !stride_phase(graph_, *state_)) return nullptr;
  const double own = pace_of(*state_).speed;
  const recon::MotionState* nearest = nullptr;
  for (const auto& state : graph_.states) {
    const double other = pace_of(state).speed;
    const bool between = (own < *speed_ && *speed_ < other) || (other < *speed_ && *speed_ < own);
    if (!between || !stride_phase(graph_, state)) continue;
    if (!nearest || std::abs(other - *speed_) < std::abs(pace_of(*nearest).speed - *speed_)) nearest = &state;
  }
  return nearest;
}

double CharacterPlayer::wanted_share() const {
  if (companion_->state != wanted_companion()) return 0.0;
  const auto own = pace_of(*state_), other = pace_of(*companion_->state);
  return own.speed < other.speed ? share_for(*speed_, own, other) : 1.0 - share_for(*speed_, other, own);
}

double CharacterPlayer::stride_seconds() const {
  const double own = pace_of(*state_).seconds, other = pace_of(*companion_->state).seconds;
  return (1.0 - companion_->share) * own + companion_->share * other;
}

void CharacterPlayer::lead_companion(double seconds) {
  const auto* wanted = wanted_companion();
  if (!companion_ && wanted) {
    const auto& loop = wanted->loop;
    companion_.emplace(Companion{wanted, {index_of(wanted->clip), static_cast<double>(loop.enter), {}}});
    keep_phase();
    const double heading = graph_.clip(state_->clip).heading - graph_.clip(wanted->clip).heading;
    companion_->strand.lay({0.0, 0.0, strand_->now().world_from_clip.yaw + heading});
    const Eigen::Vector2d way = place(*strand_) - place(companion_->strand);
    companion_->strand.lay({way.x(), way.y(), 0.0});
  }
  if (!companion_) return;
  const double step = kShareRate * seconds, missing = wanted_share() - companion_->share;
  companion_->share += std::clamp(missing, -step, step);
  if (companion_->share <= 0.0 && companion_->state != wanted) companion_.reset();
}

// Plays the companion on to the phase of the stride that the character is in.
void CharacterPlayer::keep_phase() {
  const auto ours = stride_phase(graph_, *state_), theirs = stride_phase(graph_, *companion_->state);
  const auto& loop = companion_->state->loop;
  auto& strand = companion_->strand;
  double way = theirs->frame_at(ours->phase_at(strand_->now().frame)) - strand.now().frame;
  way -= theirs->period * std::floor(way / theirs->period + 0.25);  // they may be a little ahead: then they wait
  while (way > 0.0) {
    const double left = loop.leave - strand.now().frame;
    if (way < left) return strand.move(way);
    strand.move(left);
    way -= left;
    strand.pass(loop, strand.now().clip);
  }
}

// Where the character turns about: the foot that stands, else the body.
Eigen::Vector2d CharacterPlayer::pivot() const {
  const auto& now = strand_->now();
  const auto& clip = graph_.clips[now.clip];
  for (auto contact = clip.contacts.rbegin(); contact != clip.contacts.rend(); ++contact)
    if (contact->begin <= now.frame && now.frame < contact->end) return now.world_from_clip * contact->place;
  return appearance().place;
}

// Who stands keeps the turn for when they go: feet that stand do not turn.
void CharacterPlayer::turn(double seconds) {
  const bool goes = graph_.clips[strand_->now().clip].speed > 0.0;
  if (!goes || turn_left_ == 0.0) return;
  const double angle = std::clamp(turn_left_, -kTurnRate * seconds, kTurnRate * seconds);
  turn_left_ -= angle;
  const FloorPose turned = FloorPose::turn_about(pivot(), angle);
  strand_->lay(turned);
  if (companion_) companion_->strand.lay(turned);
}

Appearance CharacterPlayer::appearance() const {
  Appearance seen;
  const double share = companion_share();
  if (companion_ && share > 0.0) seen.layers = companion_->strand.layers(graph_, share);
  const auto own = strand_->layers(graph_, 1.0 - share);
  seen.layers.insert(seen.layers.end(), own.begin(), own.end());
  seen.place = place_of(seen.layers, roots_);
  const auto& now = strand_->now();
  seen.heading = now.world_from_clip.yaw + graph_.clips[now.clip].heading;
  return seen;
}

}  // namespace rotunda::playback
