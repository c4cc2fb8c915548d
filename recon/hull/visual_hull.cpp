#include "recon/hull/visual_hull.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr float kSkin = 3.0F;  // cells outside of the surface with exact values

void check(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& bounds, double cell_size) {
  if (views.size() < 2) throw InvalidInput("a visual hull needs at least two views");
  if (bounds.isEmpty() || !bounds.sizes().allFinite())
    throw InvalidInput("the volume to search is empty: give one, or let it be found from the cameras");
  if (!(cell_size > 0.0)) throw InvalidInput("the cell size must be positive");
}

bool may_be_inside(std::span<const SilhouetteView> views, const Eigen::Vector3d& centre, double radius,
                   const VisualHullOptions& options) {
  int seen = 0, outside = 0;
  for (const auto& view : views) {
    const auto sight = view.ball(centre, radius);
    seen += sight.may_be_seen ? 1 : 0;
    outside += sight.is_outside ? 1 : 0;
    if (outside > options.tolerate_misses) return false;
  }
  return seen >= options.min_views;
}

// Cubes of one level that may hold something, in their order.
std::vector<Eigen::Vector3i> keep_occupied(std::span<const SilhouetteView> views, std::vector<Eigen::Vector3i> cubes,
                                           const Eigen::Vector3d& origin, double size, double margin,
                                           const VisualHullOptions& options) {
  std::vector<char> keep(cubes.size());
  tbb::parallel_for(std::size_t{0}, cubes.size(), [&](std::size_t i) {
    const Eigen::Vector3d centre = origin + size * (cubes[i].cast<double>() + Eigen::Vector3d::Constant(0.5));
    keep[i] = may_be_inside(views, centre, 0.5 * std::sqrt(3.0) * size + margin, options) ? 1 : 0;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cubes.size(); ++i)
    if (keep[i] != 0) cubes[kept++] = cubes[i];
  cubes.resize(kept);
  return cubes;
}

std::vector<Eigen::Vector3i> children_within(const std::vector<Eigen::Vector3i>& cubes, const Eigen::Vector3i& end) {
  std::vector<Eigen::Vector3i> children;
  children.reserve(cubes.size() * 8);
  for (const auto& cube : cubes)
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3i child = 2 * cube + Eigen::Vector3i(i & 1, (i >> 1) & 1, i >> 2);
      if ((child.array() < end.array()).all()) children.push_back(child);
    }
  return children;
}

std::vector<Eigen::Vector3i> search(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& bounds,
                                    double cube_size, double margin, const VisualHullOptions& options) {
  const Eigen::Vector3d counts = (bounds.sizes() / cube_size).array().ceil().max(1.0);
  constexpr double kMost = 1 << 19;
  if (counts.maxCoeff() > kMost) throw InvalidInput("the cells are too small for the volume to search");
  const Eigen::Vector3i end = counts.cast<int>();
  int levels = 0;
  while ((1 << levels) < end.maxCoeff()) ++levels;
  std::vector<Eigen::Vector3i> cubes{Eigen::Vector3i::Zero()};
  for (int level = levels; level >= 0; --level) {
    const Eigen::Vector3i level_end =
        (end + Eigen::Vector3i::Constant((1 << level) - 1)).unaryExpr([level](int n) { return n >> level; });
    if (level != levels) cubes = children_within(cubes, level_end);
    cubes = keep_occupied(views, std::move(cubes), bounds.min(), cube_size * (1 << level), margin, options);
    if (cubes.size() > SignedGrid::kMaxBlocks)
      throw InvalidInput(
          fmt::format("the silhouettes leave more than {} cubes of {:.4g}: use larger cells or a "
                      "smaller volume",
                      SignedGrid::kMaxBlocks, cube_size));
  }
  return cubes;
}

float hull_distance(std::span<const SilhouetteView> views, const Eigen::Vector3d& point, float outside,
                    const VisualHullOptions& options) {
  int seen = 0;
  float least = std::numeric_limits<float>::max();
  for (const auto& view : views) {
    const auto distance = view.distance(point);
    if (!distance) continue;
    ++seen;
    least = std::min(least, *distance);
    if (least <= outside) return outside;
  }
  return seen >= options.min_views ? least : outside;
}

// As above, leaving the `tolerate_misses` least distances out.
float tolerant_distance(std::span<const SilhouetteView> views, const Eigen::Vector3d& point, float outside,
                        const VisualHullOptions& options) {
  std::vector<float> distances;
  for (const auto& view : views)
    if (const auto distance = view.distance(point)) distances.push_back(*distance);
  const auto misses = static_cast<std::size_t>(options.tolerate_misses);
  if (distances.size() < std::max(static_cast<std::size_t>(options.min_views), misses + 1)) return outside;
  const auto kept = distances.begin() + options.tolerate_misses;
  std::nth_element(distances.begin(), kept, distances.end());
  return std::max(*kept, outside);
}

void fill_block(std::span<const SilhouetteView> views, SignedGrid& grid, std::size_t block,
                const VisualHullOptions& options) {
  auto& values = grid.values(block);
  const auto first = static_cast<VoxelId>(block * SignedGrid::kBlockSize);
  for (VoxelId i = 0; i < SignedGrid::kBlockSize; ++i) {
    const Eigen::Vector3d point = grid.position(first + i);
    values[i] = options.tolerate_misses == 0 ? hull_distance(views, point, grid.outside(), options)
                                             : tolerant_distance(views, point, grid.outside(), options);
  }
}

}  // namespace

std::vector<Eigen::Vector3i> occupied_cubes(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& bounds,
                                            double cube_size, const VisualHullOptions& options) {
  check(views, bounds, cube_size);
  return search(views, bounds, cube_size, 0.0, options);
}

std::vector<double> denied_shares(std::span<const SilhouetteView> views, const SignedGrid& grid) {
  std::vector<double> shares(views.size(), 0.0);
  std::vector<VoxelId> inside;
  for (VoxelId id = 0; id < grid.voxel_count(); ++id)
    if (grid.value(id) > 0.0F) inside.push_back(id);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    const auto denied = std::count_if(inside.begin(), inside.end(), [&](VoxelId id) {
      const auto distance = views[i].distance(grid.position(id));
      return distance && static_cast<double>(*distance) < -grid.cell_size();
    });
    if (!inside.empty()) shares[i] = static_cast<double>(denied) / static_cast<double>(inside.size());
  });
  return shares;
}

SignedGrid visual_hull(std::span<const SilhouetteView> views, const VisualHullOptions& options) {
  check(views, options.bounds, options.cell_size);
  const double block_size = options.cell_size * SignedGrid::kSide;
  // Blocks a cell beside the surface are kept too: both ends of every crossed edge need their own value.
  auto blocks = search(views, options.bounds, block_size, 2.0 * options.cell_size, options);
  const float outside = -kSkin * static_cast<float>(options.cell_size);
  SignedGrid grid(options.bounds.min(), options.cell_size, outside, std::move(blocks));
  tbb::parallel_for(std::size_t{0}, grid.block_count(), [&](std::size_t b) { fill_block(views, grid, b, options); });
  return grid;
}

SignedGrid visual_hull(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                       const VisualHullOptions& options) {
  return visual_hull(silhouette_views(cameras, mattes), options);
}

}  // namespace rotunda::recon
