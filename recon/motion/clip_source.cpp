#include "recon/motion/clip_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "recon/motion/frame_similarity.h"
#include "recon/motion/gait_events.h"

namespace rotunda::recon {
namespace {

constexpr int kShapeLevel = 7;
constexpr double kLeap = 8.0;           // m/s: nobody's middle is faster in a studio
constexpr double kCorresponds = 0.040;  // metres rms: the same moment in the same lattice
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

}  // namespace

ClipSource::ClipSource(const CharacterTake& take) : take_(take), video_(take.video) {
  const auto& path = video_.header().root_path;
  const double leap = kLeap / video_.header().fps;
  int begin = 0;
  for (int frame = 1; frame <= video_.frame_count(); ++frame) {
    const auto at = static_cast<std::size_t>(frame);
    if (frame < video_.frame_count() && (path[at] - path[at - 1]).head<2>().norm() < leap) continue;
    if (frame - begin > end_ - first_) {
      first_ = begin;
      end_ = frame;
    }
    begin = frame;
  }
}

GeometryImage ClipSource::read(int frame) {
  return video_.read(first_ + frame);
}

ClipShape ClipSource::shape() {
  std::vector<GeometryImage> kept;
  for (int frame = 0; frame < frame_count(); ++frame) kept.push_back(read(frame));
  return clip_shape(kept, take_.name, std::min(kShapeLevel, video_.header().level), video_.header().fps);
}

// One by one they join those that correspond already; who is left over does not.
void check_lattices(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes) {
  check_people(sources, shapes);
  std::vector<bool> joined(shapes.size(), false);
  joined.front() = true;
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t i = 0; i < shapes.size(); ++i)
      for (std::size_t j = 0; j < shapes.size() && !joined[i]; ++j)
        if (joined[j] && nearest_moment(shapes[i], shapes[j]) < kCorresponds) joined[i] = grown = true;
  }
  for (std::size_t i = 0; i < shapes.size(); ++i)
    if (!joined[i])
      throw InvalidInput(fmt::format(
          "{} does not correspond with {} sample by sample: they are in different lattices, or have no pose in common",
          sources[i].take().take, sources.front().take().take));
}

}  // namespace rotunda::recon
