#include "recon/motion/clip_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "config/errors.h"
#include "recon/motion/frame_similarity.h"
#include "recon/motion/gait_events.h"

namespace rotunda::recon {
namespace {

constexpr int kShapeLevel = 7;
constexpr double kLeap = 8.0;           // m/s: nobody's middle is faster in a studio
constexpr double kCorresponds = 0.040;  // metres rms: the same moment in the same lattice
constexpr double kJump = 0.050;         // metres rms from a frame to the next, and
constexpr double kJumpsOut = 3.0;       // times what is before and after it: nobody starts and stops within a frame
constexpr double kSamePerson = 0.05;    // share of the height by which one person's takes differ

double nearest_moment(const ClipShape& a, const ClipShape& b) {
  if (a.level != b.level) return 1e9;
  const PairTable table(a, b);
  double nearest = 1e9;
  for (int i = 0; i < table.rows(); ++i)
    for (int j = 0; j < table.columns(); ++j) nearest = std::min(nearest, table.window(i, j, 1).distance);
  return nearest;
}

double height_of(const ClipShape& clip) {
  return gait_events(clip).height;
}

// One by one they join those that correspond already.
std::vector<bool> joined_with_first(const std::vector<ClipShape>& shapes) {
  std::vector<bool> joined(shapes.size(), false);
  joined.front() = true;
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t i = 0; i < shapes.size(); ++i)
      for (std::size_t j = 0; j < shapes.size() && !joined[i]; ++j)
        if (joined[j] && nearest_moment(shapes[i], shapes[j]) < kCorresponds) joined[i] = grown = true;
  }
  return joined;
}

// Root mean square over the surface, from each frame to the next.
std::vector<double> steps_of(const ClipShape& shape) {
  std::vector<double> steps;
  for (std::size_t i = 0; i + 1 < shape.frames.size(); ++i) {
    double sum = 0.0, area = 0.0;
    for (std::size_t k = 0; k < shape.areas.size(); ++k) {
      sum += static_cast<double>(shape.areas[k] * (shape.frames[i + 1][k] - shape.frames[i][k]).squaredNorm());
      area += static_cast<double>(shape.areas[k]);
    }
    steps.push_back(std::sqrt(sum / std::max(area, 1e-12)));
  }
  return steps;
}

// The longest part of `frames` between the frames before which there is a jump.
std::pair<int, int> longest_part(int frames, const std::vector<int>& jumps) {
  std::pair<int, int> longest{0, 0};
  int begin = 0;
  const auto end_part = [&](int end) {
    if (end - begin > longest.second - longest.first) longest = {begin, end};
    begin = end;
  };
  for (const int jump : jumps) end_part(jump);
  end_part(frames);
  return longest;
}

}  // namespace

void check_people(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes) {
  const double first = height_of(shapes.front());
  for (std::size_t i = 1; i < shapes.size(); ++i) {
    const double height = height_of(shapes[i]);
    if (std::abs(height - first) > kSamePerson * first)
      throw InvalidInput(fmt::format(
          "{} and {} show different people, {:.2f} m and {:.2f} m tall; a character is one person: build one for each",
          sources.front().take().take, sources[i].take().take, first, height));
  }
}

ClipSource::ClipSource(const CharacterTake& take) : take_(take), video_(take.video) {
  const auto& path = video_.header().root_path;
  const double leap = kLeap / video_.header().fps;
  std::vector<int> jumps;
  for (std::size_t frame = 1; frame < path.size(); ++frame)
    if ((path[frame] - path[frame - 1]).head<2>().norm() >= leap) jumps.push_back(static_cast<int>(frame));
  std::tie(first_, end_) = longest_part(video_.frame_count(), jumps);
}

void ClipSource::cut_jumps(ClipShape& shape) {
  const auto steps = steps_of(shape);
  std::vector<int> jumps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double before = i > 0 ? steps[i - 1] : 0.0, after = i + 1 < steps.size() ? steps[i + 1] : 0.0;
    if (steps[i] > kJump && steps[i] > kJumpsOut * std::max(before, after)) jumps.push_back(static_cast<int>(i) + 1);
  }
  const auto [begin, end] = longest_part(shape.frame_count(), jumps);
  const auto keep = [begin = begin, end = end](auto& all) {
    if (!all.empty()) all = {all.begin() + begin, all.begin() + end};
  };
  keep(shape.frames);
  keep(shape.colours);
  end_ = first_ + end;
  first_ += begin;
}

GeometryImage ClipSource::read(int frame) {
  return video_.read(first_ + frame);
}

ClipShape ClipSource::shape() {
  std::vector<GeometryImage> kept;
  for (int frame = 0; frame < frame_count(); ++frame) kept.push_back(read(frame));
  return clip_shape(kept, take_.name, std::min(kShapeLevel, video_.header().level), video_.header().fps);
}

void check_lattices(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes) {
  const auto joined = joined_with_first(shapes);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    if (!joined[i])
      throw InvalidInput(fmt::format(
          "{} does not correspond with {} sample by sample: they are in different lattices, or have no pose in common",
          sources[i].take().take, sources.front().take().take));
}

}  // namespace rotunda::recon
