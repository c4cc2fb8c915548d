#include "simulator/studio/shadow.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

constexpr float kCell = 0.018F;    // of a map, metres: no wider than triangles are long
constexpr float kOffset = 0.020F;  // a point looks for its light from so far off its surface
constexpr float kBias = 0.012F;    // and what lies so little nearer to the light does not shade it
constexpr int kSurroundings = 14;  // directions of the upper half space
const Vector3f kStage(0.0F, 0.0F, 1.0F);

// Four points of a lamp's square, seen from the middle of the stage.
std::vector<Vector3f> directions_of(const Lamp& lamp) {
  const Vector3f towards = (lamp.place - kStage).normalized();
  const Vector3f any = std::abs(towards.z()) < 0.9F ? Vector3f::UnitZ() : Vector3f::UnitX();
  const Vector3f right = any.cross(towards).normalized(), up = towards.cross(right);
  std::vector<Vector3f> directions;
  for (const auto& [x, y] : {std::pair{-0.8F, -0.3F}, {0.3F, -0.8F}, {0.8F, 0.3F}, {-0.3F, 0.8F}})
    directions.push_back((lamp.place + 0.5F * lamp.size * (x * right + y * up) - kStage).normalized());
  return directions;
}

// Evenly over the upper half space and a little below the horizon, by the golden angle.
std::vector<Vector3f> directions_around() {
  std::vector<Vector3f> directions;
  for (int i = 0; i < kSurroundings; ++i) {
    const double z = 0.97 - 1.05 * i / (kSurroundings - 1), around = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double across = std::sqrt(1.0 - z * z);
    directions.push_back(Eigen::Vector3d(across * std::cos(around), across * std::sin(around), z).cast<float>());
  }
  return directions;
}

// Calls `each` with points of the surface no more than a cell apart.
template <class Each>
void sample(const recon::TriangleMesh& surface, const Each& each) {
  for (const auto& p : surface.positions) each(p);
  for (const auto& t : surface.triangles) {
    const Vector3f a = surface.positions[t[0]], u = surface.positions[t[1]] - a, v = surface.positions[t[2]] - a;
    const float longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int steps = std::min(200, static_cast<int>(longest / kCell) + 1);
    if (steps == 1) {
      if (longest > 0.6F * kCell) each(a + (u + v) / 3.0F);
      continue;
    }
    for (int j = 0; j <= steps; ++j)
      for (int i = 0; i + j <= steps; ++i)
        each(a + (static_cast<float>(i) * u + static_cast<float>(j) * v) / static_cast<float>(steps));
  }
}

}  // namespace

ShadowMaps::Map ShadowMaps::map_along(const Vector3f& direction, const std::vector<recon::TriangleMesh>& surfaces) {
  Map map;
  map.towards = direction;
  const Vector3f any = std::abs(direction.z()) < 0.9F ? Vector3f::UnitZ() : Vector3f::UnitX();
  map.right = any.cross(direction).normalized();
  map.up = direction.cross(map.right);
  Eigen::Array2f low = Eigen::Array2f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (const auto& surface : surfaces)
    for (const auto& p : surface.positions) {
      const Eigen::Array2f here(map.right.dot(p), map.up.dot(p));
      low = low.min(here);
      high = high.max(here);
    }
  if (!(low <= high).all() || ((high - low) > 20.0F).any()) return map;  // nobody there: all is open
  map.from_right = low.x() - 1.5F * kCell;
  map.from_up = low.y() - 1.5F * kCell;
  map.columns = static_cast<int>((high.x() - low.x()) / kCell) + 5;
  map.rows = static_cast<int>((high.y() - low.y()) / kCell) + 5;
  map.foremost.assign(static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows),
                      -std::numeric_limits<float>::max());
  for (const auto& surface : surfaces)
    sample(surface, [&](const Vector3f& p) {
      const int column = static_cast<int>((map.right.dot(p) - map.from_right) / kCell);
      const int row = static_cast<int>((map.up.dot(p) - map.from_up) / kCell);
      float& cell = map.foremost[static_cast<std::size_t>(row * map.columns + column)];
      cell = std::max(cell, map.towards.dot(p));
    });
  return map;
}

float ShadowMaps::Map::open(const Vector3f& point) const {
  const float column = (right.dot(point) - from_right) / kCell - 0.5F, row = (up.dot(point) - from_up) / kCell - 0.5F;
  if (!(column >= 0.0F && row >= 0.0F && column < static_cast<float>(columns - 1) &&
        row < static_cast<float>(rows - 1)))
    return 1.0F;
  const int i = static_cast<int>(column), j = static_cast<int>(row);
  const float u = column - static_cast<float>(i), v = row - static_cast<float>(j);
  const float* upper = foremost.data() + j * columns + i;
  const float* lower = upper + columns;
  const float limit = towards.dot(point) + kBias;
  const auto passes = [&](float blocker) { return blocker > limit ? 0.0F : 1.0F; };
  return (1.0F - v) * ((1.0F - u) * passes(upper[0]) + u * passes(upper[1])) +
         v * ((1.0F - u) * passes(lower[0]) + u * passes(lower[1]));
}

ShadowMaps::ShadowMaps(const std::vector<recon::TriangleMesh>& surfaces) {
  std::vector<std::pair<Map*, Vector3f>> wanted;
  for (std::size_t i = 0; i < kLamps; ++i) {
    const auto directions = directions_of(lamps()[i]);
    lamps_[i].resize(directions.size());
    for (std::size_t d = 0; d < directions.size(); ++d) wanted.emplace_back(&lamps_[i][d], directions[d]);
  }
  const auto around = directions_around();
  surroundings_.resize(around.size());
  for (std::size_t d = 0; d < around.size(); ++d) wanted.emplace_back(&surroundings_[d], around[d]);
  tbb::parallel_for(std::size_t{0}, wanted.size(),
                    [&](std::size_t i) { *wanted[i].first = map_along(wanted[i].second, surfaces); });
}

Visibility ShadowMaps::at(const Vector3f& position, const Vector3f& normal) const {
  const Vector3f from = position + kOffset * normal;
  Visibility visibility;
  for (std::size_t i = 0; i < kLamps; ++i) {
    visibility.lamps[i] = 0.0F;
    for (const auto& map : lamps_[i]) visibility.lamps[i] += map.open(from) / static_cast<float>(lamps_[i].size());
  }
  float seen = 0.0F, all = 0.0F;
  for (const auto& map : surroundings_) {
    const float facing = 0.15F + std::max(0.0F, normal.dot(map.towards));
    seen += facing * map.open(from);
    all += facing;
  }
  visibility.surroundings = seen / all;
  return visibility;
}

}  // namespace rotunda::simulator
