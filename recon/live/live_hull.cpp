#include "recon/live/live_hull.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <limits>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr int kLeastViews = 2;
constexpr float kSkin = 3.0F;    // cells: what is farther outside is all the same
constexpr int kPart = 4;         // samples a side of the parts of a block that are judged as a whole
constexpr float kBeside = 1.1F;  // cells: both ends of every crossed edge need their own value

bool may_be_inside(std::span<const LiveSilhouette> views, const Eigen::Vector3f& centre, float radius) {
  int seen = 0;
  for (const auto& view : views) {
    const auto sight = view.ball(centre, radius);
    if (sight.is_outside) return false;
    seen += sight.may_be_seen ? 1 : 0;
  }
  return seen >= kLeastViews;
}

// Cubes of `size` that may hold something, coarse to fine; `margin` around each is looked at as well.
std::vector<Eigen::Vector3i> occupied(std::span<const LiveSilhouette> views, const Eigen::AlignedBox3d& bounds,
                                      double size, double margin) {
  const Eigen::Vector3d counts = (bounds.sizes() / size).array().ceil().max(1.0);
  if (counts.maxCoeff() > 1 << 19) throw InvalidInput("the cells are too small for the volume to search");
  const Eigen::Vector3i end = counts.cast<int>();
  int levels = 0;
  while ((1 << levels) < end.maxCoeff()) ++levels;
  std::vector<Eigen::Vector3i> cubes{Eigen::Vector3i::Zero()}, kept;
  for (int level = levels; level >= 0; --level) {
    const double edge = size * (1 << level);
    kept.clear();
    for (const auto& cube : cubes) {
      const Eigen::Vector3d centre = bounds.min() + edge * (cube.cast<double>() + Eigen::Vector3d::Constant(0.5));
      const bool within = ((cube * (1 << level)).array() < end.array()).all();
      if (within &&
          may_be_inside(views, centre.cast<float>(), static_cast<float>(0.5 * std::sqrt(3.0) * edge + margin)))
        kept.push_back(cube);
    }
    if (kept.size() > SignedGrid::kMaxBlocks)
      throw InvalidInput(fmt::format("the silhouettes leave more than {} cubes of {:.4g}: use larger cells",
                                     SignedGrid::kMaxBlocks, edge));
    if (level == 0) break;
    cubes.clear();
    for (const auto& cube : kept)
      for (int i = 0; i < 8; ++i) cubes.push_back(2 * cube + Eigen::Vector3i(i & 1, (i >> 1) & 1, i >> 2));
  }
  return kept;
}

// The views that some of a part's samples may lie outside of, and what the others say.
struct PartSight {
  std::vector<const LiveSilhouette*> open;
  int seen = 0;                                        // by how many of the others
  float distance = std::numeric_limits<float>::max();  // the least of theirs at the part's middle
  bool is_outside = false;
};

void look(std::span<const LiveSilhouette> views, const Eigen::Vector3f& centre, float radius, PartSight& part) {
  part.open.clear();
  part.seen = 0;
  part.distance = std::numeric_limits<float>::max();
  part.is_outside = false;
  for (const auto& view : views) {
    const auto sight = view.ball(centre, radius);
    if (sight.is_outside) {
      part.is_outside = true;
      return;
    }
    if (!sight.may_be_seen) continue;
    if (!sight.is_inside) {
      part.open.push_back(&view);
      continue;
    }
    ++part.seen;
    part.distance = std::min(part.distance, sight.distance);
  }
}

float distance_of(const PartSight& part, const Eigen::Vector3f& point, float outside) {
  int seen = part.seen;
  float least = part.distance;
  LivePixel pixel;
  for (const auto* view : part.open) {
    if (!view->project(point, pixel)) continue;
    ++seen;
    least = std::min(least, view->distance_at(pixel) * pixel.depth / view->focal());
    if (least <= outside) return outside;
  }
  return seen >= kLeastViews ? least : outside;
}

void fill_part(const SignedGrid& grid, const Eigen::Vector3f& first, const PartSight& part, float* values) {
  const auto cell = static_cast<float>(grid.cell_size());
  for (int z = 0; z < kPart; ++z)
    for (int y = 0; y < kPart; ++y)
      for (int x = 0; x < kPart; ++x)
        values[x + 8 * y + 64 * z] =
            distance_of(part, first + cell * Eigen::Vector3i(x, y, z).cast<float>(), grid.outside());
}

void fill_block(std::span<const LiveSilhouette> views, SignedGrid& grid, std::size_t block) {
  const auto cell = static_cast<float>(grid.cell_size());
  const float radius = cell * (0.5F * std::sqrt(3.0F) * (kPart - 1) + kBeside);
  auto& values = grid.values(block);
  PartSight part;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i low = kPart * Eigen::Vector3i(i & 1, (i >> 1) & 1, i >> 2);
    const Eigen::Vector3d corner =
        grid.origin() + grid.cell_size() * (grid.block(block) * SignedGrid::kSide + low).cast<double>();
    const Eigen::Vector3f first = corner.cast<float>();
    look(views, first + Eigen::Vector3f::Constant(0.5F * (kPart - 1) * cell), radius, part);
    if (!part.is_outside) fill_part(grid, first, part, values.data() + low.x() + 8 * low.y() + 64 * low.z());
  }
}

}  // namespace

SignedGrid live_hull(std::span<const LiveSilhouette> views, const Eigen::AlignedBox3d& bounds, double cell_size) {
  if (bounds.isEmpty() || !bounds.sizes().allFinite())
    throw InvalidInput("the volume to search is empty: give one, or let it be found from the cameras");
  if (!(cell_size > 0.0)) throw InvalidInput("the cell size must be positive");
  auto blocks = occupied(views, bounds, cell_size * SignedGrid::kSide, 2.0 * cell_size);
  SignedGrid grid(bounds.min(), cell_size, -kSkin * static_cast<float>(cell_size), std::move(blocks));
  tbb::parallel_for(std::size_t{0}, grid.block_count(), [&](std::size_t b) { fill_block(views, grid, b); });
  return grid;
}

}  // namespace rotunda::recon
