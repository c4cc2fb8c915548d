#include "recon/motion/motion_seam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rotunda::recon {
namespace {

constexpr double kSameMoment = 0.050;      // metres rms: the paper's sigma; frames farther apart show different moments
constexpr double kShortestCycle = 0.8;     // seconds, of people who stand
constexpr double kNotMuchWorse = 1.5;      // of the best seam's distance ...
constexpr double kNotMuchFarther = 0.004;  // ... or metres beyond it
constexpr double kPatience = 0.4;          // seconds between ways out of a state, where they will do:
constexpr double kPassable = 0.025;        // metres rms
constexpr int kLongestLeave = 15;          // frames of a blend between clips
constexpr double kStandsOut = 1.5;         // of a clip's median largest step: what is more is seen
constexpr double kSlides = 10.0;           // millimetres that a standing foot goes: what is more is seen
constexpr int kLongestBlend = 25;          // frames: a second; the quiet motions of standing bear it
constexpr double kSole = 0.03;             // metres above the floor
constexpr float kHold = 50.0F;             // what a standing foot's surface counts against the rest

struct Found {
  int leave = 0, enter = 0;
  double distance = 1e9;
};

// Nobody sees a seam of 1 and less.
double flaw(const Join& join) {
  return std::max(join.price.step_ratio / kStandsOut, join.price.slide_mm / kSlides);
}

// Of seams that nobody sees the one whose surfaces are nearest, else the one that stands out least.
bool better(const Join& a, const Join& b) {
  const bool seen = std::max(flaw(a), flaw(b)) > 1.0;
  return seen ? flaw(a) < flaw(b) : a.price.error_mm < b.price.error_mm;
}

double not_much_worse(double best) {
  return std::max(kNotMuchWorse * best, best + kNotMuchFarther);
}

// Strides of one foot, in frames.
std::vector<int> strides(const GaitEvents& events) {
  std::vector<int> lengths;
  for (std::size_t i = 0; i < events.strikes.size(); ++i)
    for (std::size_t j = i + 1; j < events.strikes.size(); ++j)
      if (events.strikes[j].side == events.strikes[i].side) {
        lengths.push_back(events.strikes[j].frame - events.strikes[i].frame);
        break;
      }
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

// Cycles of these lengths, the most alike ends first.
std::vector<Found> periods(const PairTable& table, int shortest, int longest, int blend) {
  std::vector<Found> found;
  for (int period = shortest; period <= longest; ++period)
    for (int enter = 0; enter + period + blend <= table.rows(); ++enter)
      found.push_back({enter + period, enter, table.window(enter + period, enter, blend).distance});
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
  return found;
}

// Of those not much worse than the first, the longest first: standing people repeat themselves least that way.
std::vector<Found> longest(std::vector<Found> found) {
  if (found.empty()) return found;
  const double good = std::max(kNotMuchWorse * found.front().distance, 0.5 * kNotMuchFarther);
  const auto end = std::partition_point(found.begin(), found.end(), [&](const auto& f) { return f.distance <= good; });
  found.erase(end, found.end());
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.leave - a.enter > b.leave - b.enter; });
  return found;
}

// The best of those not much worse than the first.
std::optional<Join> best_loop(const MovingClip& clip, const std::vector<Found>& found, int blend) {
  constexpr std::size_t kTried = 40;
  std::optional<Join> best;
  for (std::size_t i = 0; i < std::min(kTried, found.size()); ++i) {
    if (found[i].distance > std::min(kSameMoment, not_much_worse(found.front().distance))) break;
    const Join loop = make_join(clip, clip, found[i].leave, found[i].enter, blend);
    if (!best || better(loop, *best)) best = loop;
  }
  return best;
}

bool low(const MovingClip& clip, const Eigen::Vector3f& position) {
  return static_cast<double>(position.z()) < clip.events.floor_height + kSole;
}

std::vector<Eigen::Vector3f> laid(const FloorPose& pose, const std::vector<Eigen::Vector3f>& positions) {
  const auto c = static_cast<float>(std::cos(pose.yaw)), s = static_cast<float>(std::sin(pose.yaw));
  const auto x = static_cast<float>(pose.x), y = static_cast<float>(pose.y);
  std::vector<Eigen::Vector3f> result;
  result.reserve(positions.size());
  for (const auto& p : positions) result.emplace_back(c * p.x() - s * p.y() + x, s * p.x() + c * p.y() + y, p.z());
  return result;
}

const std::vector<Eigen::Vector3f>& frame_of(const MovingClip& clip, int frame) {
  return clip.shape.frames[static_cast<std::size_t>(std::clamp(frame, 0, clip.shape.frame_count() - 1))];
}

double colour_error(const MovingClip& from, const MovingClip& to, const Join& join) {
  if (from.shape.colours.empty() || to.shape.colours.empty()) return 0.0;
  double sum = 0.0, area = 0.0;
  for (int k = 0; k < join.blend; ++k) {
    const auto& a = from.shape.colours[static_cast<std::size_t>(join.leave + k)];
    const auto& b = to.shape.colours[static_cast<std::size_t>(join.enter + k)];
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double difference = static_cast<double>(a[i][c]) - static_cast<double>(b[i][c]);
        sum += static_cast<double>(from.shape.areas[i]) * difference * difference;
        area += static_cast<double>(from.shape.areas[i]);
      }
  }
  return std::sqrt(sum / std::max(area, 1e-12));
}

// How far the foot that stands through the whole seam goes meanwhile: its sole, about where it stands.
double slide(const MovingClip& from, const Join& join, const std::vector<std::vector<Eigen::Vector3f>>& frames) {
  constexpr double kFoot = 0.2;  // metres about a foot's middle
  double farthest = 0.0;
  for (const auto& contact : from.events.contacts) {
    if (contact.begin > join.leave || contact.end < join.leave + join.blend) continue;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double area = 0.0;
    for (std::size_t i = 0; i < frames.front().size(); ++i) {
      const Eigen::Vector2d at = frames.front()[i].head<2>().cast<double>();
      if (!low(from, frames.front()[i]) || !low(from, frames.back()[i]) || (at - contact.place).norm() > kFoot)
        continue;
      sum += static_cast<double>(from.shape.areas[i]) * (frames.back()[i].head<2>().cast<double>() - at);
      area += static_cast<double>(from.shape.areas[i]);
    }
    if (area > 0.0) farthest = std::max(farthest, (sum / area).norm());
  }
  return farthest;
}

SeamPrice price_of(const MovingClip& from, const MovingClip& to, const Join& join) {
  SeamPrice price;
  double squares = 0.0, area = 0.0;
  for (int k = 0; k < join.blend; ++k) {
    const auto& a = frame_of(from, join.leave + k);
    const auto b = laid(join.pose, frame_of(to, join.enter + k));
    for (std::size_t i = 0; i < a.size(); ++i) {
      const auto distance = static_cast<double>((a[i] - b[i]).norm());
      squares += static_cast<double>(from.shape.areas[i]) * distance * distance;
      area += static_cast<double>(from.shape.areas[i]);
      price.largest_mm = std::max(price.largest_mm, 1000.0 * distance);
    }
  }
  price.error_mm = 1000.0 * std::sqrt(squares / std::max(area, 1e-12));
  std::vector<std::vector<Eigen::Vector3f>> frames;
  for (int k = -1; k <= join.blend; ++k) frames.push_back(blended_frame(from, to, join, k));
  double largest = 0.0;
  for (std::size_t k = 0; k + 1 < frames.size(); ++k)
    largest = std::max(largest, largest_step(frames[k], frames[k + 1]));
  price.step_ratio = largest / std::max(std::max(from.median_step, to.median_step), 1e-6);
  price.slide_mm = 1000.0 * slide(from, join, frames);
  price.colour = colour_error(from, to, join);
  return price;
}

std::string no_cycle(const MovingClip& clip, const Found& best) {
  if (clip.shape.frame_count() < static_cast<int>(kShortestCycle * clip.shape.fps))
    return fmt::format("{} is too short: {} frames; record at least two seconds of it", clip.shape.name,
                       clip.shape.frame_count());
  if (clip.events.speed > 0.0 && strides(clip.events).empty())
    return fmt::format("{} goes, but no foot strikes the floor twice: it has no cycle; record at least two strides",
                       clip.shape.name);
  if (best.leave == 0)
    return fmt::format("{} is too short for a cycle and the frames to blend it with; record half a second more",
                       clip.shape.name);
  return fmt::format(
      "{} has no cycle: the frames most alike, {} and {}, are {:.0f} mm apart (at most {:.0f}); record it until it "
      "repeats, or name it A-B if it leads from one state to another",
      clip.shape.name, best.enter, best.leave, 1000.0 * best.distance, 1000.0 * kSameMoment);
}

// For every frame left the best one entered.
std::vector<Found> best_enters(const MovingClip& from, const MovingClip& to, const JoinRange& range, int blend) {
  const PairTable table(from.shape, to.shape);
  const int leave_end = std::min(range.end, from.shape.frame_count() - blend + 1);
  const int enter_end = std::min(range.enter_end, to.shape.frame_count() - blend + 1);
  std::vector<Found> found;
  for (int leave = range.first; leave < leave_end; ++leave) {
    Found nearest{leave, 0, 1e9};
    for (int enter = range.enter_first; enter < enter_end; ++enter) {
      const double distance = table.window(leave, enter, blend).distance;
      if (distance < nearest.distance) nearest = {leave, enter, distance};
    }
    found.push_back(nearest);
  }
  return found;
}

// Those not much worse than the best; and where a command would wait longer than it may, the best of the wait if it
// will do.
std::vector<Found> kept(const std::vector<Found>& found, double limit, int patience) {
  double best = limit;
  for (const auto& one : found) best = std::min(best, one.distance);
  const double good = std::min(limit, not_much_worse(best));
  const double passable = std::min(limit, std::max(good, kPassable));
  std::vector<Found> chosen;
  for (std::size_t i = 0; i < found.size();) {
    if (found[i].distance <= good) {
      chosen.push_back(found[i++]);
      continue;
    }
    std::size_t end = i;
    while (end < found.size() && found[end].distance > good) ++end;
    for (; i + static_cast<std::size_t>(patience) < end; i += static_cast<std::size_t>(patience)) {
      const auto first = found.begin() + static_cast<std::ptrdiff_t>(i);
      const auto nearest = std::min_element(first, first + patience,
                                            [](const auto& a, const auto& b) { return a.distance < b.distance; });
      if (nearest->distance <= passable) chosen.push_back(*nearest);
    }
    i = end;
  }
  return chosen;
}

// Seams that are seen are left out where another is within the patience before or after.
std::vector<Join> least_seen(std::vector<Join> joins, int patience) {
  std::vector<int> unseen;
  for (const auto& join : joins)
    if (flaw(join) <= 1.0) unseen.push_back(join.leave);
  std::erase_if(joins, [&](const Join& join) {
    return flaw(join) > 1.0 &&
           std::ranges::any_of(unseen, [&](int leave) { return std::abs(leave - join.leave) <= patience; });
  });
  return joins;
}

std::vector<Join> joins_within(double limit, const MovingClip& from, const MovingClip& to, const JoinRange& range,
                               int blend) {
  const int patience = std::max(1, static_cast<int>(std::lround(kPatience * from.shape.fps)));
  std::vector<Join> joins;
  for (const auto& one : kept(best_enters(from, to, range, blend), limit, patience)) {
    if (one.distance >= limit) continue;
    Join join = make_join(from, to, one.leave, one.enter, blend);
    const int longest =
        std::min({kLongestLeave, from.shape.frame_count() - one.leave, to.shape.frame_count() - one.enter});
    for (int longer = blend + 1; flaw(join) > 1.0 && longer <= longest; longer += 2) {
      const Join slower = make_join(from, to, one.leave, one.enter, longer);
      if (flaw(slower) < flaw(join)) join = slower;
    }
    joins.push_back(join);
  }
  return least_seen(std::move(joins), patience);
}

}  // namespace

MovingClip moving_clip(ClipShape shape) {
  MovingClip clip;
  clip.events = gait_events(shape);
  clip.shape = std::move(shape);
  travel(clip.shape, clip.events);
  std::vector<double> steps;
  for (int i = 0; i + 1 < clip.shape.frame_count(); ++i)
    steps.push_back(largest_step(frame_of(clip, i), frame_of(clip, i + 1)));
  std::sort(steps.begin(), steps.end());
  if (!steps.empty()) clip.median_step = steps[steps.size() / 2];
  return clip;
}

double largest_step(const std::vector<Eigen::Vector3f>& from, const std::vector<Eigen::Vector3f>& to) {
  float largest = 0.0F;
  for (std::size_t i = 0; i < from.size(); ++i) largest = std::max(largest, (to[i] - from[i]).squaredNorm());
  return std::sqrt(static_cast<double>(largest));
}

CycleSearch find_cycle(const MovingClip& clip, int blend) {
  const PairTable table(clip.shape, clip.shape);
  std::vector<Found> found;
  if (clip.events.speed > 0.0) {
    const auto lengths = strides(clip.events);
    const int stride = lengths.empty() ? 0 : lengths[lengths.size() / 2];
    if (stride > 0) found = periods(table, stride - 1, stride + 1, blend);
    const auto loop = best_loop(clip, found, blend);
    return {loop, loop ? "" : no_cycle(clip, found.empty() ? Found{} : found.front())};
  }
  const int shortest = static_cast<int>(std::lround(kShortestCycle * clip.shape.fps));
  found = periods(table, shortest, table.rows() - blend, blend);
  CycleSearch search;
  for (int longer = blend; longer <= std::max(blend, kLongestBlend); longer += 5) {
    const auto loop =
        best_loop(clip, longest(periods(table, std::max(shortest, longer), table.rows() - longer, longer)), longer);
    if (loop && (!search.loop || better(*loop, *search.loop))) search.loop = loop;
    if (search.loop && flaw(*search.loop) <= 1.0) break;
  }
  if (!search.loop) search.failure = no_cycle(clip, found.empty() ? Found{} : found.front());
  return search;
}

const Join& best_seam(const std::vector<Join>& joins) {
  return *std::min_element(joins.begin(), joins.end(), better);
}

std::vector<Join> find_joins(const MovingClip& from, const MovingClip& to, const JoinRange& range, int blend) {
  return joins_within(kSameMoment, from, to, range, blend);
}

std::vector<Join> nearest_joins(const MovingClip& from, const MovingClip& to, const JoinRange& range, int blend) {
  return joins_within(1e6, from, to, range, blend);
}

Join make_join(const MovingClip& from, const MovingClip& to, int leave, int enter, int blend) {
  const auto& a = frame_of(from, leave + blend / 2);
  const auto& b = frame_of(to, enter + blend / 2);
  auto weights = from.shape.areas;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (low(from, a[i]) && low(to, b[i])) weights[i] *= kHold;
  Join join{.leave = leave, .enter = enter, .blend = blend, .pose = lay_over(a, b, weights).pose};
  join.price = price_of(from, to, join);
  return join;
}

std::vector<Eigen::Vector3f> blended_frame(const MovingClip& from, const MovingClip& to, const Join& join, int k) {
  const auto weight = static_cast<float>(blend_weight(k, join.blend));
  auto frame = laid(join.pose, frame_of(to, join.enter + k));
  if (weight >= 1.0F) return frame;
  const auto& left = frame_of(from, join.leave + k);
  for (std::size_t i = 0; i < frame.size(); ++i) frame[i] = (1.0F - weight) * left[i] + weight * frame[i];
  return frame;
}

}  // namespace rotunda::recon
