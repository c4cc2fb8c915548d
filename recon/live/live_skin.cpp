#include "recon/live/live_skin.h"

#include <algorithm>
#include <array>
#include <queue>
#include <vector>

#include "config/errors.h"
#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3i;

enum class Mark : std::uint8_t { outside, inside, body, queued, grown, air };

// The samples around all that is inside, two more on every side.
struct Box {
  Vector3i low, sides;
  std::vector<Mark> marks;
  std::vector<float> values;
  std::array<std::ptrdiff_t, 27> around{};  // to the neighbour (dx + 1) + 3 (dy + 1) + 9 (dz + 1)

  std::size_t index(const Vector3i& at) const {
    const Vector3i p = at - low;
    return static_cast<std::size_t>(p.x()) +
           static_cast<std::size_t>(sides.x()) *
               (static_cast<std::size_t>(p.y()) +
                static_cast<std::size_t>(sides.y()) * static_cast<std::size_t>(p.z()));
  }
};
constexpr std::size_t kSelf = 13;
constexpr std::array<std::size_t, 6> kFaces{4, 10, 12, 14, 16, 22};
constexpr int kMargin = 2;

template <class Visit>
void for_each_inside(const SignedGrid& grid, Visit visit) {
  for (std::size_t block = 0; block < grid.block_count(); ++block) {
    const auto& values = grid.values(block);
    for (VoxelId local = 0; local < SignedGrid::kBlockSize; ++local)
      if (values[local] > 0.0F) visit(static_cast<VoxelId>(block * SignedGrid::kBlockSize) + local, values[local]);
  }
}

Box box_around(const SignedGrid& grid) {
  Vector3i low = Vector3i::Constant(1 << 30), high = Vector3i::Constant(-(1 << 30));
  for_each_inside(grid, [&](VoxelId id, float) {
    const Vector3i at = grid.coordinates(id);
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  });
  Box box;
  if (low.x() > high.x()) return box;
  box.low = low.array() - kMargin;
  box.sides = high - low + Vector3i::Constant(1 + 2 * kMargin);
  const double samples = box.sides.cast<double>().prod();
  if (samples > 1 << 27) throw InvalidInput("the performer is too large for cells so small: use larger cells");
  box.marks.assign(static_cast<std::size_t>(samples), Mark::outside);
  box.values.assign(static_cast<std::size_t>(samples), grid.outside());
  for_each_inside(grid, [&](VoxelId id, float value) {
    const auto at = box.index(grid.coordinates(id));
    box.marks[at] = Mark::inside;
    box.values[at] = value;
  });
  const std::ptrdiff_t row = box.sides.x(), layer = row * box.sides.y();
  for (int i = 0; i < 27; ++i)
    box.around[static_cast<std::size_t>(i)] = i % 3 - 1 + row * (i / 3 % 3 - 1) + layer * (i / 9 - 1);
  return box;
}

std::size_t beside(const Box& box, std::size_t at, std::size_t neighbour) {
  return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + box.around[neighbour]);
}

// Turns the 26-component of `seed` from inside into body; returns its samples.
std::vector<std::size_t> flood(Box& box, std::size_t seed) {
  std::vector<std::size_t> reached{seed};
  box.marks[seed] = Mark::body;
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (std::size_t n = 0; n < 27; ++n) {
      const auto next = beside(box, reached[i], n);
      if (box.marks[next] != Mark::inside) continue;
      box.marks[next] = Mark::body;
      reached.push_back(next);
    }
  return reached;
}

// The largest 26-component as body; the others become outside.
std::vector<std::size_t> keep_largest(Box& box) {
  std::vector<std::size_t> largest;
  for (std::size_t at = 0; at < box.marks.size(); ++at) {
    if (box.marks[at] != Mark::inside) continue;
    auto piece = flood(box, at);
    if (piece.size() > largest.size()) std::swap(piece, largest);
    for (const auto lost : piece) box.marks[lost] = Mark::outside;
  }
  return largest;
}

// Outside samples that no 6-path leads to from the box's border are cavities: they join the body.
void fill_cavities(Box& box, float value) {
  const auto is_border = [&](const Vector3i& p) {
    return (p.array() == 0).any() || (p.array() == box.sides.array() - 1).any();
  };
  std::vector<std::size_t> air;
  std::size_t at = 0;
  for (int z = 0; z < box.sides.z(); ++z)
    for (int y = 0; y < box.sides.y(); ++y)
      for (int x = 0; x < box.sides.x(); ++x, ++at)
        if (is_border({x, y, z})) box.marks[at] = Mark::air;  // and nothing is walked beyond it
  const Vector3i first = box.low + Vector3i::Ones();
  air.push_back(box.index(first));
  box.marks[air.front()] = Mark::air;
  for (std::size_t i = 0; i < air.size(); ++i)
    for (const auto face : kFaces) {
      const auto next = beside(box, air[i], face);
      if (box.marks[next] != Mark::outside) continue;
      box.marks[next] = Mark::air;
      air.push_back(next);
    }
  for (std::size_t i = 0; i < box.marks.size(); ++i) {
    if (box.marks[i] != Mark::outside) continue;
    box.marks[i] = Mark::body;
    box.values[i] = value;
  }
}

std::uint32_t grown_around(const Box& box, std::size_t at) {
  std::uint32_t inside = 0;
  for (std::size_t n = 0; n < 27; ++n)
    inside |= static_cast<std::uint32_t>(box.marks[beside(box, at, n)] == Mark::grown) << n;
  return inside & ~(1U << kSelf);
}

// From the deepest sample; what was refused is asked again when a neighbour joins.
std::size_t grow(Box& box, std::size_t seed) {
  using Candidate = std::pair<float, std::uint32_t>;
  const auto later = [](const Candidate& a, const Candidate& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  };
  std::priority_queue<Candidate, std::vector<Candidate>, decltype(later)> queue(later);
  std::size_t grown = 0;
  const auto accept = [&](std::size_t at) {
    box.marks[at] = Mark::grown;
    ++grown;
    for (std::size_t n = 0; n < 27; ++n) {
      const auto next = beside(box, at, n);
      if (box.marks[next] != Mark::body) continue;
      box.marks[next] = Mark::queued;
      queue.emplace(box.values[next], static_cast<std::uint32_t>(next));
    }
  };
  accept(seed);
  while (!queue.empty()) {
    const std::size_t at = queue.top().second;
    queue.pop();
    box.marks[at] = Mark::body;
    if (is_simple(grown_around(box, at))) accept(at);
  }
  return grown;
}

// What was dropped, filled or cut, to the grid.
void write_back(const Box& box, SignedGrid& grid) {
  const auto cell = static_cast<float>(grid.cell_size());
  for (std::size_t block = 0; block < grid.block_count(); ++block) {
    const auto first = static_cast<VoxelId>(block * SignedGrid::kBlockSize);
    const Vector3i corner = grid.coordinates(first) - box.low;
    if ((corner.array() + SignedGrid::kSide <= 0).any() || (corner.array() >= box.sides.array()).any()) continue;
    auto& values = grid.values(block);
    for (VoxelId local = 0; local < SignedGrid::kBlockSize; ++local) {
      const Vector3i at = grid.coordinates(first + local), p = at - box.low;
      if ((p.array() < 0).any() || (p.array() >= box.sides.array()).any()) continue;
      const auto i = box.index(at);
      const bool was_inside = values[local] > 0.0F;
      if (box.marks[i] == Mark::grown)
        values[local] = was_inside ? values[local] : box.values[i];
      else if (box.marks[i] == Mark::body)
        values[local] = -0.25F * cell;
      else if (was_inside)
        values[local] = grid.outside();
    }
  }
}

}  // namespace

std::size_t live_cut(SignedGrid& grid) {
  auto box = box_around(grid);
  if (box.marks.empty()) return 0;
  const auto body = keep_largest(box);
  fill_cavities(box, static_cast<float>(0.5 * grid.cell_size()));
  const auto seed = *std::max_element(body.begin(), body.end(), [&](std::size_t a, std::size_t b) {
    return box.values[a] != box.values[b] ? box.values[a] < box.values[b] : a > b;
  });
  const auto grown = grow(box, seed);
  write_back(box, grid);
  return grown;
}

TriangleMesh live_skin(SignedGrid& grid, double margin) {
  return live_cut(grid) == 0 ? TriangleMesh{} : marching_cubes(grid, margin);
}

}  // namespace rotunda::recon
