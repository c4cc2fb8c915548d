#include "recon/hull/genus_cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <queue>
#include <vector>

namespace rotunda::recon {
namespace {

constexpr int kSelf = 13;
constexpr std::uint32_t kAll = ((1U << 27) - 1U) & ~(1U << kSelf);

constexpr int dx_of(int i) {
  return i % 3 - 1;
}
constexpr int dy_of(int i) {
  return i / 3 % 3 - 1;
}
constexpr int dz_of(int i) {
  return i / 9 - 1;
}

struct Adjacency {
  std::array<std::uint32_t, 27> by_corner{};  // 26-neighbours of each place, within the 3^3 cube, centre left out
  std::array<std::uint32_t, 27> by_face{};    // 6-neighbours
  std::uint32_t faces = 0;                    // the centre's own 6-neighbours
  std::uint32_t faces_and_edges = 0;          // its 18-neighbours
};

constexpr Adjacency make_adjacency() {
  Adjacency a;
  for (int i = 0; i < 27; ++i) {
    const int reach = dx_of(i) * dx_of(i) + dy_of(i) * dy_of(i) + dz_of(i) * dz_of(i);
    if (reach == 1) a.faces |= 1U << i;
    if (reach == 1 || reach == 2) a.faces_and_edges |= 1U << i;
    for (int j = 0; j < 27; ++j) {
      if (i == j || j == kSelf) continue;
      const int x = dx_of(i) - dx_of(j), y = dy_of(i) - dy_of(j), z = dz_of(i) - dz_of(j);
      if (x * x <= 1 && y * y <= 1 && z * z <= 1) a.by_corner[static_cast<std::size_t>(i)] |= 1U << j;
      if (x * x + y * y + z * z == 1) a.by_face[static_cast<std::size_t>(i)] |= 1U << j;
    }
  }
  return a;
}

constexpr Adjacency kAdjacency = make_adjacency();

std::uint32_t component(std::uint32_t set, std::uint32_t seed, const std::array<std::uint32_t, 27>& adjacency) {
  std::uint32_t reached = seed, front = seed;
  while (front != 0) {
    std::uint32_t next = 0;
    for (auto rest = front; rest != 0; rest &= rest - 1)
      next |= adjacency[static_cast<std::size_t>(std::countr_zero(rest))];
    front = next & set & ~reached;
    reached |= front;
  }
  return reached;
}

// Marks of samples while the solid is taken apart and grown anew.
enum class Mark : std::uint8_t { Outside, Body, Queued, Grown, Air };

std::vector<VoxelId> inside_of(const SignedGrid& grid) {
  std::vector<VoxelId> body;
  for (VoxelId id = 0; id < grid.voxel_count(); ++id)
    if (grid.value(id) > 0.0F) body.push_back(id);
  return body;
}

bool is_open(const SignedGrid& grid, VoxelId id) {
  return grid.neighbour(id, 1, 0, 0) == kNoVoxel || grid.neighbour(id, -1, 0, 0) == kNoVoxel ||
         grid.neighbour(id, 0, 1, 0) == kNoVoxel || grid.neighbour(id, 0, -1, 0) == kNoVoxel ||
         grid.neighbour(id, 0, 0, 1) == kNoVoxel || grid.neighbour(id, 0, 0, -1) == kNoVoxel;
}

// Outside samples that no 6-path leads to from beyond the stored blocks are cavities: they join the body.
// (A cavity of whole missing blocks cannot be: blocks are left out only where a view sees through to the background.)
void fill_cavities(SignedGrid& grid, std::vector<Mark>& marks, std::vector<VoxelId>& body, GenusCutReport& report) {
  std::vector<VoxelId> air;
  for (VoxelId id = 0; id < marks.size(); ++id)
    if (marks[id] == Mark::Outside && is_open(grid, id)) {
      marks[id] = Mark::Air;
      air.push_back(id);
    }
  constexpr std::array<std::array<int, 3>, 6> kSteps{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  for (std::size_t i = 0; i < air.size(); ++i)
    for (const auto& s : kSteps) {
      const auto n = grid.neighbour(air[i], s[0], s[1], s[2]);
      if (n == kNoVoxel || marks[n] != Mark::Outside) continue;
      marks[n] = Mark::Air;
      air.push_back(n);
    }
  for (VoxelId id = 0; id < marks.size(); ++id) {
    if (marks[id] != Mark::Outside) continue;
    marks[id] = Mark::Body;
    grid.set_value(id, static_cast<float>(0.5 * grid.cell_size()));
    body.push_back(id);
    ++report.filled_voxels;
  }
}

std::uint32_t grown_neighbours(const SignedGrid& grid, const std::vector<Mark>& marks, VoxelId id) {
  std::uint32_t inside = 0;
  for (int i = 0; i < 27; ++i) {
    const auto n = grid.neighbour(id, dx_of(i), dy_of(i), dz_of(i));
    if (n != kNoVoxel && marks[n] == Mark::Grown) inside |= 1U << i;
  }
  return inside;
}

// Grows from the deepest sample; what was refused is asked again when a neighbour joins.
std::size_t grow(const SignedGrid& grid, std::vector<Mark>& marks, VoxelId seed) {
  using Candidate = std::pair<float, VoxelId>;
  const auto later = [](const Candidate& a, const Candidate& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  };
  std::priority_queue<Candidate, std::vector<Candidate>, decltype(later)> queue(later);
  std::size_t grown = 0;
  const auto accept = [&](VoxelId id) {
    marks[id] = Mark::Grown;
    ++grown;
    grid.for_each_neighbour(id, [&](VoxelId n) {
      if (n == kNoVoxel || marks[n] != Mark::Body) return;
      marks[n] = Mark::Queued;
      queue.emplace(grid.value(n), n);
    });
  };
  accept(seed);
  while (!queue.empty()) {
    const auto id = queue.top().second;
    queue.pop();
    marks[id] = Mark::Body;
    if (is_simple(grown_neighbours(grid, marks, id))) accept(id);
  }
  return grown;
}

}  // namespace

bool is_simple(std::uint32_t inside_neighbours) {
  const auto inside = inside_neighbours & kAll;
  if (inside == 0) return false;
  if (component(inside, inside & (~inside + 1U), kAdjacency.by_corner) != inside) return false;
  const auto outside = ~inside & kAdjacency.faces_and_edges;
  const auto touching = outside & kAdjacency.faces;
  if (touching == 0) return false;
  return (touching & ~component(outside, touching & (~touching + 1U), kAdjacency.by_face)) == 0;
}

GenusCutReport cut_to_genus_zero(SignedGrid& grid, const PieceRule& rule) {
  GenusCutReport report{.pieces = settle_pieces(grid, rule)};
  auto body = inside_of(grid);
  if (body.empty()) return report;
  std::vector<Mark> marks(grid.voxel_count(), Mark::Outside);
  for (const auto id : body) marks[id] = Mark::Body;
  fill_cavities(grid, marks, body, report);
  const auto seed = *std::max_element(body.begin(), body.end(), [&](VoxelId a, VoxelId b) {
    return grid.value(a) != grid.value(b) ? grid.value(a) < grid.value(b) : a > b;
  });
  report.solid_voxels = grow(grid, marks, seed);
  for (const auto id : body) {
    if (marks[id] == Mark::Grown) continue;
    grid.set_value(id, static_cast<float>(-0.25 * grid.cell_size()));
    ++report.cut_voxels;
  }
  return report;
}

}  // namespace rotunda::recon
