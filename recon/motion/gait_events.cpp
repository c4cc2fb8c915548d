#include "recon/motion/gait_events.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "recon/motion/foot_track.h"

namespace rotunda::recon {
namespace {

constexpr double kFlat = 0.35;        // share of the widest sole from which a foot stands
constexpr double kStands = 0.08;      // m/s: a floor that is slower stands still
constexpr double kGoes = 0.25;        // m/s: who is slower stands
constexpr double kDown = 0.030;       // metres above the floor below which a foot may have landed: the surface's error
constexpr double kLifted = 0.06;      // metres: no shifted weight lifts a heel that far
constexpr double kCarried = 0.5;      // share of the person's speed at which the floor takes a foot back
constexpr double kLeastSwing = 0.06;  // of the height: how far a foot overtakes the body in half a step, or more
constexpr double kSway = 0.005;       // metres: what body and surface move by themselves
constexpr double kStepTime = 0.2;     // seconds: no foot strikes twice within twice that

using Feet = std::vector<FootState>;

double widest_sole(const FootTracks& tracks) {
  double widest = 0.0;
  for (const auto& feet : tracks.feet)
    for (const auto& foot : feet) widest = std::max(widest, foot.sole);
  return widest;
}

struct Weighed {
  double value, weight;
};

double median(std::vector<Weighed> values) {
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  double all = 0.0, sum = 0.0;
  for (const auto& v : values) all += v.weight;
  for (const auto& v : values)
    if ((sum += v.weight) >= 0.5 * all) return v.value;
  return 0.0;
}

// The one velocity that feet have while they stand flat (metres a frame): a median in which the flattest count most,
// as the middle of a rolling foot runs ahead.
Eigen::Vector2d floor_step(const FootTracks& tracks, double flat) {
  std::array<std::vector<Weighed>, 2> steps;
  for (const auto& feet : tracks.feet)
    for (std::size_t i = 0; i + 1 < feet.size(); ++i) {
      const double sole = std::min(feet[i].sole, feet[i + 1].sole);
      if (!feet[i].seen || !feet[i + 1].seen || sole < flat) continue;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        steps[axis].push_back({feet[i + 1].place[k] - feet[i].place[k], std::pow(sole, 4.0)});
      }
    }
  if (steps[0].size() < 4) return Eigen::Vector2d::Zero();
  return {median(steps[0]), median(steps[1])};
}

// The way that standing feet point.
double facing(const FootTracks& tracks, double flat) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& feet : tracks.feet)
    for (const auto& foot : feet)
      if (foot.seen && foot.sole >= flat) sum += (foot.place - foot.ankle).normalized();
  return sum.norm() > 0.0 ? std::atan2(sum.y(), sum.x()) : 0.0;
}

// How far ahead of the body the foot is; nothing where it is not seen.
std::vector<std::optional<double>> ahead(const ClipShape& clip, const Feet& feet, const Eigen::Vector2d& forward) {
  std::vector<std::optional<double>> way(feet.size());
  for (std::size_t i = 0; i < feet.size(); ++i)
    if (feet[i].seen) way[i] = forward.dot(feet[i].place - middle_of(clip, static_cast<int>(i)).head<2>());
  return way;
}

// Overtakes the body no further. Who stops after a step keeps it there.
bool ends_swing(const std::vector<std::optional<double>>& way, int at, int reach) {
  const auto value = [&](int i) { return way[static_cast<std::size_t>(i)]; };
  const int last = static_cast<int>(way.size()) - 1;
  if (at < 1 || at >= last || !value(at - 1) || !value(at + 1)) return false;
  for (int i = at + 1; i <= std::min(last, at + reach); ++i)
    if (value(i) && *value(i) > *value(at) + kSway) return false;
  return true;
}

// A foot slows down against the body only when the floor has it: then it is low, or goes back as the floor does. (A
// heel's tip is what reconstruction loses first: the foot of a striking heel looks some centimetres too high.)
bool has_landed(const Feet& feet, const std::vector<std::optional<double>>& way, int at, double carried) {
  const auto i = static_cast<std::size_t>(at);
  if (!feet[i].seen) return false;
  return feet[i].height <= kDown || (way[i] && way[i - 1] && *way[i - 1] - *way[i] >= carried);
}

void find_strikes(const ClipShape& clip, const Feet& feet, Side side, const Eigen::Vector2d& forward,
                  const GaitEvents& known, std::vector<HeelStrike>& strikes) {
  const auto way = ahead(clip, feet, forward);
  const int reach = static_cast<int>(std::lround(kStepTime * clip.fps)), last = static_cast<int>(feet.size()) - 1;
  double least = std::numeric_limits<double>::max();  // since the strike before
  for (int at = 0; at <= last; ++at) {
    const auto& here = way[static_cast<std::size_t>(at)];
    if (!here) continue;
    least = std::min(least, *here);
    if (*here - least < kLeastSwing * known.height || !ends_swing(way, at, reach)) continue;
    int down = at + 1;
    while (down <= last && down <= at + reach && !has_landed(feet, way, down, kCarried * known.speed / clip.fps))
      ++down;
    if (down > std::min(last, at + reach)) continue;
    strikes.push_back({down, side});
    least = std::numeric_limits<double>::max();
    at = down;
  }
}

// Of who stays: a foot that was lifted comes down.
void find_landings(const Feet& feet, Side side, double flat, std::vector<HeelStrike>& strikes) {
  bool lifted = false;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const bool down = feet[i].seen && feet[i].sole >= flat;
    if (lifted && down) strikes.push_back({static_cast<int>(i), side});
    lifted = !down && (lifted || feet[i].height > kLifted);  // 0 where legs that touch hide it
  }
}

void find_contacts(const FootTracks& tracks, const Feet& feet, Side side, double flat, const Eigen::Vector2d& step,
                   std::vector<FootContact>& contacts) {
  const auto place = [&](std::size_t i) { return Eigen::Vector2d(feet[i].place - static_cast<double>(i) * step); };
  const double still = 0.006 * tracks.person_height;  // metres a frame, about a centimetre
  const auto stands = [&](std::size_t i) { return feet[i].seen && feet[i].sole >= flat; };
  for (std::size_t i = 0; i < feet.size();) {
    std::size_t end = i;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    while (end < feet.size() && stands(end) && (end == i || (place(end) - place(end - 1)).norm() < still)) {
      sum += place(end);
      ++end;
    }
    if (end >= i + 2)
      contacts.push_back({static_cast<int>(i), static_cast<int>(end), side, sum / static_cast<double>(end - i)});
    i = std::max(end, i + 1);
  }
}

// Whether foot 0 is the left one: over most frames it is to the left of the other.
bool first_is_left(const FootTracks& tracks, const Eigen::Vector2d& forward) {
  double sum = 0.0;
  for (std::size_t i = 0; i < tracks.feet[0].size(); ++i)
    if (tracks.feet[0][i].seen && tracks.feet[1][i].seen) {
      const Eigen::Vector2d across = tracks.feet[0][i].ankle - tracks.feet[1][i].ankle;
      sum += forward.x() * across.y() - forward.y() * across.x();
    }
  return sum >= 0.0;
}

}  // namespace

GaitEvents gait_events(const ClipShape& clip) {
  GaitEvents events;
  if (clip.frame_count() < 2) return events;
  const FootTracks tracks = track_feet(clip);
  events.floor_height = tracks.floor_height;
  events.height = tracks.person_height;
  const double flat = kFlat * widest_sole(tracks), frames = clip.frame_count() - 1;
  Eigen::Vector2d step = floor_step(tracks, flat);
  if (step.norm() * clip.fps < kStands) step.setZero();
  events.floor_velocity = step * clip.fps;
  const Eigen::Vector2d way = (middle_of(clip, clip.frame_count() - 1) - middle_of(clip, 0)).head<2>();
  const Eigen::Vector2d velocity = way * clip.fps / frames - events.floor_velocity;
  const bool goes = velocity.norm() > kGoes;
  events.speed = goes ? velocity.norm() : 0.0;
  events.heading = goes ? std::atan2(velocity.y(), velocity.x()) : facing(tracks, flat);
  const Eigen::Vector2d forward(std::cos(events.heading), std::sin(events.heading));
  const std::size_t left = first_is_left(tracks, forward) ? 0 : 1;
  for (const std::size_t foot : {left, 1 - left}) {
    const Side side = foot == left ? Side::left : Side::right;
    if (goes)
      find_strikes(clip, tracks.feet[foot], side, forward, events, events.strikes);
    else
      find_landings(tracks.feet[foot], side, flat, events.strikes);
    find_contacts(tracks, tracks.feet[foot], side, flat, step, events.contacts);
  }
  std::sort(events.strikes.begin(), events.strikes.end(), [](auto a, auto b) { return a.frame < b.frame; });
  std::sort(events.contacts.begin(), events.contacts.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  return events;
}

void travel(ClipShape& clip, const GaitEvents& events) {
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    const Eigen::Vector2f way = (-events.floor_velocity * (static_cast<double>(i) / clip.fps)).cast<float>();
    for (auto& position : clip.frames[i]) position.head<2>() += way;
  }
}

}  // namespace rotunda::recon
