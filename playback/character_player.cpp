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
  tracks_.push_back({clip, static_cast<double>(state_->loop.enter), {-turned.x(), -turned.y(), -heading}, 0, 0.0});
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
}

double CharacterPlayer::rate() const {
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
  const Track& now = tracks_.back();
  Seam seam{&state_->loop, state_->clip, nullptr, state_};
  const auto* transition = wanted_transition();
  if (transition == nullptr || tracks_.size() >= kMostTracks) return seam;
  for (const auto& leave : transition->leaves) {
    if (leave.leave <= now.frame + 1e-9 || leave.leave > state_->loop.leave) continue;
    const auto& to = graph_.state(transition->to);
    if (transition->synthesised()) return {&leave, to.clip, nullptr, &to};
    return {&leave, transition->clip, transition, nullptr};
  }
  return seam;
}

void CharacterPlayer::pass(const Seam& seam) {
  const FloorPose world = tracks_.back().world_from_clip * seam.join->pose;
  tracks_.push_back({index_of(seam.clip), static_cast<double>(seam.join->enter), world, seam.join->blend, 0.0});
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

void CharacterPlayer::move(double frames) {
  for (auto& track : tracks_) track.frame += frames;
  for (std::size_t i = 1; i < tracks_.size(); ++i) tracks_[i].blended += frames;
  while (tracks_.size() > 1 && recon::blend_weight(tracks_[1].blended, tracks_[1].blend) >= 1.0)
    tracks_.erase(tracks_.begin());
}

void CharacterPlayer::advance(double seconds) {
  double frames = seconds * graph_.fps * rate();
  turn(seconds);
  while (frames > 0.0) {
    const Seam seam = next_seam();
    const double way = std::max(0.0, seam.join->leave - tracks_.back().frame);
    if (frames + 1e-9 < way) return move(frames);
    move(way);
    frames -= way;
    pass(seam);
    if (frames < 1e-9) return;
  }
}

// Where the character turns about: the foot that stands, else the body.
Eigen::Vector2d CharacterPlayer::pivot() const {
  const Track& now = tracks_.back();
  const auto& clip = graph_.clips[now.clip];
  for (auto contact = clip.contacts.rbegin(); contact != clip.contacts.rend(); ++contact)
    if (contact->begin <= now.frame && now.frame < contact->end) return now.world_from_clip * contact->place;
  return appearance().place;
}

// Who stands keeps the turn for when they go: feet that stand do not turn.
void CharacterPlayer::turn(double seconds) {
  const bool goes = graph_.clips[tracks_.back().clip].speed > 0.0;
  if (!goes || turn_left_ == 0.0) return;
  const double angle = std::clamp(turn_left_, -kTurnRate * seconds, kTurnRate * seconds);
  turn_left_ -= angle;
  const FloorPose turned = FloorPose::turn_about(pivot(), angle);
  for (auto& track : tracks_) track.world_from_clip = turned * track.world_from_clip;
}

Appearance CharacterPlayer::appearance() const {
  Appearance seen;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const double weight = i == 0 ? 1.0 : recon::blend_weight(tracks_[i].blended, tracks_[i].blend);
    for (auto& layer : seen.layers) layer.weight *= 1.0 - weight;
    const auto last = static_cast<double>(graph_.clips[tracks_[i].clip].frames - 1);
    seen.layers.push_back({tracks_[i].clip, std::min(tracks_[i].frame, last), weight, tracks_[i].world_from_clip});
  }
  for (const auto& layer : seen.layers) {
    const auto& path = roots_[layer.clip];
    const auto at = static_cast<std::size_t>(layer.frame);
    const double part = layer.frame - static_cast<double>(at);
    const Eigen::Vector2d root = (1.0 - part) * path[at] + part * path[std::min(at + 1, path.size() - 1)];
    seen.place += layer.weight * (layer.world_from_clip * root);
  }
  const auto& now = seen.layers.back();
  seen.heading = now.world_from_clip.yaw + graph_.clips[now.clip].heading;
  return seen;
}

}  // namespace rotunda::playback
