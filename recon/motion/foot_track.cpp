#include "recon/motion/foot_track.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace rotunda::recon {
namespace {

// Shares of a person's height.
constexpr double kCuts[] = {0.36, 0.31, 0.26, 0.21, 0.17, 0.13, 0.10};  // below which legs are looked for
constexpr double kLegReach = 0.30;  // a leg's lowest point is no higher: a hanging hand's is
constexpr double kFootHeight = 0.045;
constexpr double kAnkleHeight = 0.09;
constexpr double kLeastArea = 0.003;  // of height squared: a third of a foot
constexpr double kSoleHeight = 0.03;  // metres

using Samples = std::vector<std::uint32_t>;

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Parts of the surface below a height, each joined within itself.
class Parts {
 public:
  explicit Parts(const ClipShape& clip) : clip_(clip), neighbours_(lattice_neighbours(clip.level)) {}

  std::vector<Samples> below(int frame, double height) const {
    const auto& positions = clip_.frames[static_cast<std::size_t>(frame)];
    std::vector<char> open(positions.size(), 0);
    for (std::size_t i = 0; i < positions.size(); ++i)
      open[i] = !neighbours_[i].empty() && positions[i].z() < static_cast<float>(height);
    std::vector<Samples> parts;
    for (std::uint32_t i = 0; i < open.size(); ++i)
      if (open[i]) parts.push_back(take_part(i, open));
    return parts;
  }

 private:
  Samples take_part(std::uint32_t start, std::vector<char>& open) const {
    Samples part{start};
    open[start] = 0;
    for (std::size_t next = 0; next < part.size(); ++next)
      for (const std::uint32_t other : neighbours_[part[next]])
        if (open[other]) {
          open[other] = 0;
          part.push_back(other);
        }
    std::sort(part.begin(), part.end());
    return part;
  }

  const ClipShape& clip_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
};

double area_of(const ClipShape& clip, const Samples& part) {
  double area = 0.0;
  for (const auto i : part) area += static_cast<double>(clip.areas[i]);
  return area;
}

double lowest_of(const ClipShape& clip, int frame, const Samples& part) {
  float lowest = std::numeric_limits<float>::max();
  for (const auto i : part) lowest = std::min(lowest, clip.frames[static_cast<std::size_t>(frame)][i].z());
  return static_cast<double>(lowest);
}

// Two legs where they can be told apart, one where only one reaches the floor.
std::vector<Samples> legs_in(const ClipShape& clip, const Parts& parts, const FootTracks& tracks, int frame) {
  const double height = tracks.person_height;
  std::vector<Samples> best;
  for (const double cut : kCuts) {
    std::vector<Samples> legs;
    for (auto& part : parts.below(frame, tracks.floor_height + cut * height))
      if (area_of(clip, part) >= kLeastArea * height * height &&
          lowest_of(clip, frame, part) < tracks.floor_height + kLegReach * height)
        legs.push_back(std::move(part));
    std::stable_sort(legs.begin(), legs.end(),
                     [&](const auto& a, const auto& b) { return area_of(clip, a) > area_of(clip, b); });
    if (legs.size() > 2) legs.resize(2);
    if (legs.size() > best.size()) best = std::move(legs);
    if (best.size() == 2) break;
  }
  return best;
}

Eigen::Vector2d middle(const ClipShape& clip, int frame, const Samples& part, double from, double to) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double area = 0.0;
  for (const auto i : part) {
    const auto& p = clip.frames[static_cast<std::size_t>(frame)][i];
    if (static_cast<double>(p.z()) < from || static_cast<double>(p.z()) > to) continue;
    sum += static_cast<double>(clip.areas[i]) * p.head<2>().cast<double>();
    area += static_cast<double>(clip.areas[i]);
  }
  return sum / std::max(area, 1e-12);
}

FootState state_of(const ClipShape& clip, const FootTracks& tracks, int frame, const Samples& leg) {
  const double lowest = lowest_of(clip, frame, leg), foot = kFootHeight * tracks.person_height;
  FootState state{.seen = true, .height = lowest - tracks.floor_height};
  state.place = middle(clip, frame, leg, lowest, lowest + foot);
  state.ankle = middle(clip, frame, leg, lowest + foot, lowest + kAnkleHeight * tracks.person_height);
  for (const auto i : leg)
    if (static_cast<double>(clip.frames[static_cast<std::size_t>(frame)][i].z()) < tracks.floor_height + kSoleHeight)
      state.sole += static_cast<double>(clip.areas[i]);
  return state;
}

// How much of the surface two parts share on the lattice.
double overlap(const ClipShape& clip, const Samples& a, const Samples& b) {
  Samples both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return area_of(clip, both);
}

// Which leg of the frames before each of these is: the one whose place on the lattice it has.
void follow(const ClipShape& clip, std::array<Samples, 2>& known, std::vector<Samples>& legs) {
  legs.resize(2);
  const auto gain = [&](std::size_t a, std::size_t b) { return overlap(clip, known[a], legs[b]); };
  if (gain(0, 1) + gain(1, 0) > gain(0, 0) + gain(1, 1)) std::swap(legs[0], legs[1]);
  for (std::size_t foot = 0; foot < 2; ++foot)
    if (!legs[foot].empty()) known[foot] = legs[foot];
}

void find_floor(const ClipShape& clip, FootTracks& tracks) {
  std::vector<double> lowest, highest;
  for (const auto& frame : clip.frames) {
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (const auto& p : frame) {
      low = std::min(low, p.z());
      high = std::max(high, p.z());
    }
    lowest.push_back(static_cast<double>(low));
    highest.push_back(static_cast<double>(high));
  }
  tracks.floor_height = quantile(lowest, 0.2);  // runners leave the floor for a third of the time
  tracks.person_height = quantile(highest, 0.9) - tracks.floor_height;
}

}  // namespace

FootTracks track_feet(const ClipShape& clip) {
  FootTracks tracks;
  if (clip.frames.empty()) return tracks;
  find_floor(clip, tracks);
  const Parts parts(clip);
  std::array<Samples, 2> known;
  for (int frame = 0; frame < clip.frame_count(); ++frame) {
    auto legs = legs_in(clip, parts, tracks, frame);
    follow(clip, known, legs);
    for (std::size_t foot = 0; foot < 2; ++foot)
      tracks.feet[foot].push_back(legs[foot].empty() ? FootState{} : state_of(clip, tracks, frame, legs[foot]));
  }
  return tracks;
}

}  // namespace rotunda::recon
