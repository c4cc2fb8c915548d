#include "recon/hull/marching_cubes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

namespace rotunda::recon {
namespace {

// Corners of a cube are numbered x + 2 y + 4 z. An edge is its lower corner and its axis, numbered 3 corner + axis.
constexpr int kEdges = 24;  // numbers in use are those whose lower corner has a 0 on the axis
using Loop = std::vector<int>;
using Table = std::array<std::vector<std::array<int, 3>>, 256>;

int edge_between(int a, int b) {
  const int axis = (a ^ b) >> 1;  // 1, 2, 4 to 0, 1, 2
  return 3 * std::min(a, b) + axis;
}

// Corners of each face, counter-clockwise seen from outside of the cube.
std::array<std::array<int, 4>, 6> make_faces() {
  std::array<std::array<int, 4>, 6> faces{};
  for (int axis = 0; axis < 3; ++axis) {
    const int n = 1 << axis, u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3);
    faces[static_cast<std::size_t>(2 * axis)] = {0, v, u | v, u};
    faces[static_cast<std::size_t>(2 * axis + 1)] = {n, n | u, n | u | v, n | v};
  }
  return faces;
}

// Walking round a face, every run of outside corners is cut off from the rest by a segment from the crossing where the
// walk comes back inside to the one where it left: insides are joined. Each crossing starts one segment and ends one.
std::array<int, kEdges> segments_of(int inside) {
  std::array<int, kEdges> next{};
  next.fill(-1);
  for (const auto& face : make_faces())
    for (std::size_t i = 0; i < 4; ++i) {
      const auto corner = [&](std::size_t k) { return face[(i + k) % 4]; };
      const auto in = [&](std::size_t k) { return ((inside >> corner(k)) & 1) != 0; };
      if (!in(0) || in(1)) continue;
      std::size_t back = 2;
      while (!in(back)) ++back;
      next[static_cast<std::size_t>(edge_between(corner(back - 1), corner(back)))] = edge_between(corner(0), corner(1));
    }
  return next;
}

std::vector<Loop> loops_of(int inside) {
  auto next = segments_of(inside);
  std::vector<Loop> loops;
  for (std::size_t start = 0; start < kEdges; ++start) {
    Loop loop;
    for (auto at = start; next[at] >= 0;) {
      loop.push_back(static_cast<int>(at));
      const auto following = static_cast<std::size_t>(next[at]);
      next[at] = -1;
      at = following;
    }
    if (!loop.empty()) loops.push_back(loop);
  }
  return loops;
}

// Two cube edges on one face: a diagonal between them could meet the neighbouring cube's in that face.
bool share_a_face(int a, int b) {
  const int corner_a = a / 3, corner_b = b / 3, free = (1 << (a % 3)) | (1 << (b % 3));
  return ((~(corner_a ^ corner_b)) & ~free & 7) != 0;
}

// Triangulation of loop[first..last] with the fewest diagonals that lie in a face.
int triangulate(const Loop& loop, std::size_t first, std::size_t last, std::vector<std::array<int, 3>>& triangles) {
  if (last - first < 2) return 0;
  int best = std::numeric_limits<int>::max();
  std::vector<std::array<int, 3>> best_triangles;
  for (std::size_t apex = first + 1; apex < last; ++apex) {
    std::vector<std::array<int, 3>> tried{{loop[first], loop[apex], loop[last]}};
    int cost = triangulate(loop, first, apex, tried) + triangulate(loop, apex, last, tried);
    if (apex != first + 1 && share_a_face(loop[first], loop[apex])) ++cost;
    if (apex != last - 1 && share_a_face(loop[apex], loop[last])) ++cost;
    if (cost >= best) continue;
    best = cost;
    best_triangles = tried;
  }
  triangles.insert(triangles.end(), best_triangles.begin(), best_triangles.end());
  return best;
}

// Two inside corners opposite through the cube: each side of one's triangle is joined to the other's crossing on the
// third axis (an antiprism without its caps).
std::vector<std::array<int, 3>> tube(const Loop& a, const Loop& b) {
  std::vector<std::array<int, 3>> triangles;
  const auto join = [&](const Loop& from, const Loop& to) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int u = from[i], v = from[(i + 1) % 3], third = 3 - u % 3 - v % 3;
      const int apex = *std::find_if(to.begin(), to.end(), [third](int edge) { return edge % 3 == third; });
      triangles.push_back({u, v, apex});
    }
  };
  join(a, b);
  join(b, a);
  return triangles;
}

bool is_opposite_pair(int inside) {
  return inside == 0x81 || inside == 0x42 || inside == 0x24 || inside == 0x18;
}

Table make_table() {
  Table table;
  for (int inside = 1; inside < 255; ++inside) {
    auto& triangles = table[static_cast<std::size_t>(inside)];
    const auto loops = loops_of(inside);
    if (is_opposite_pair(inside)) {
      triangles = tube(loops[0], loops[1]);
      continue;
    }
    for (const auto& loop : loops) triangulate(loop, 0, loop.size() - 1, triangles);
  }
  return table;
}

// A block's samples with one more on every side.
struct Padded {
  static constexpr int kSide = SignedGrid::kSide + 2;
  static constexpr int kRow = kSide, kLayer = kSide * kSide;
  std::array<float, kSide * kSide * kSide> value;
  std::array<std::uint8_t, kSide * kSide * kSide> inside;
  std::array<VoxelId, kSide * kSide * kSide> id;  // kNoVoxel: not stored
  static std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>((x + 1) + kRow * (y + 1) + kLayer * (z + 1));
  }
};

// How far the samples of a cube's corners are from its first.
constexpr std::array<std::size_t, 8> kCorner{0,
                                             1,
                                             Padded::kRow,
                                             Padded::kRow + 1,
                                             Padded::kLayer,
                                             Padded::kLayer + 1,
                                             Padded::kLayer + Padded::kRow,
                                             Padded::kLayer + Padded::kRow + 1};

// False if all samples are of one side.
bool gather(const SignedGrid& grid, std::size_t block, Padded& padded) {
  const auto first = static_cast<VoxelId>(block * SignedGrid::kBlockSize);
  const auto& own = grid.values(block);
  std::size_t inside = 0, at = 0;
  for (int z = -1; z <= 8; ++z)
    for (int y = -1; y <= 8; ++y)
      for (int x = -1; x <= 8; ++x, ++at) {
        const int cx = std::clamp(x, 0, 7), cy = std::clamp(y, 0, 7), cz = std::clamp(z, 0, 7);
        const auto local = static_cast<VoxelId>(cx | (cy << 3) | (cz << 6));
        const bool is_own = cx == x && cy == y && cz == z;
        padded.id[at] = is_own ? first + local : grid.neighbour(first + local, x - cx, y - cy, z - cz);
        padded.value[at] = is_own ? own[local] : grid.value(padded.id[at]);
        padded.inside[at] = padded.value[at] > 0.0F ? 1 : 0;
        inside += padded.inside[at];
      }
  return inside != 0 && inside != padded.inside.size();
}

// A cell belongs to the block of its first stored corner; is that this block?
bool owns_cell(const Padded& padded, int x, int y, int z) {
  for (int c = 0; c < 8; ++c) {
    const int cx = x + (c & 1), cy = y + ((c >> 1) & 1), cz = z + (c >> 2);
    if (padded.id[Padded::index(cx, cy, cz)] == kNoVoxel) continue;
    return ((cx | cy | cz) & ~7) == 0;
  }
  return false;
}

class Extraction {
 public:
  Extraction(const SignedGrid& grid, double margin)
      : grid_(grid), margin_(margin), table_(shared_table()), on_edge_(3 * grid.voxel_count(), kNone) {}

  void add_block(std::size_t block) {
    if (!gather(grid_, block, padded_)) return;
    const Eigen::Vector3i base = grid_.block(block) * SignedGrid::kSide;
    for (int z = -1; z < 8; ++z)
      for (int y = -1; y < 8; ++y)
        for (int x = -1; x < 8; ++x) add_cell(base, x, y, z);
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  static const Table& shared_table() {
    static const Table table = make_table();
    return table;
  }

  void add_cell(const Eigen::Vector3i& base, int x, int y, int z) {
    const auto first = Padded::index(x, y, z);
    unsigned inside = 0;
    for (std::size_t c = 0; c < 8; ++c) inside |= static_cast<unsigned>(padded_.inside[first + kCorner[c]]) << c;
    if (inside == 0 || inside == 255 || !owns_cell(padded_, x, y, z)) return;
    for (const auto& triangle : table_[inside]) {
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t i = 0; i < 3; ++i) corners[i] = vertex_on(base, x, y, z, triangle[i]);
      mesh_.triangles.push_back(corners);
    }
  }

  std::uint32_t vertex_on(const Eigen::Vector3i& base, int x, int y, int z, int edge) {
    const int corner = edge / 3, axis = edge % 3;
    const Eigen::Vector3i low(x + (corner & 1), y + ((corner >> 1) & 1), z + (corner >> 2));
    const auto at = Padded::index(low.x(), low.y(), low.z());
    auto& vertex = place_of(padded_.id[at], base + low, axis);
    if (vertex != kNone) return vertex;
    vertex = static_cast<std::uint32_t>(mesh_.positions.size());
    add_vertex(base + low, axis, padded_.value[at], padded_.value[at + kCorner[std::size_t{1} << axis]]);
    return vertex;
  }

  // Of the edge that goes up from a sample: where its vertex is noted.
  std::uint32_t& place_of(VoxelId id, const Eigen::Vector3i& at, int axis) {
    if (id != kNoVoxel) return on_edge_[3 * std::size_t{id} + static_cast<std::size_t>(axis)];
    constexpr int kBias = 1 << 19;
    const auto part = [](int c) { return static_cast<std::uint64_t>(c + kBias) & 0xFFFFFU; };
    const auto key =
        part(at.x()) | (part(at.y()) << 20) | (part(at.z()) << 40) | (static_cast<std::uint64_t>(axis) << 60);
    return beyond_.try_emplace(key, kNone).first->second;
  }

  void add_vertex(const Eigen::Vector3i& low, int axis, float from, float to) {
    const double crossing = static_cast<double>(from) / (static_cast<double>(from) - static_cast<double>(to));
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(axis) * std::clamp(crossing, margin_, 1.0 - margin_);
    mesh_.positions.push_back((grid_.origin() + grid_.cell_size() * (low.cast<double>() + along)).cast<float>());
  }

  const SignedGrid& grid_;
  double margin_;  // cells
  const Table& table_;
  Padded padded_{};
  std::vector<std::uint32_t> on_edge_;                       // three a stored sample
  std::unordered_map<std::uint64_t, std::uint32_t> beyond_;  // of samples that are not stored
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh marching_cubes(const SignedGrid& grid, double margin) {
  Extraction extraction(grid, margin);
  for (std::size_t block = 0; block < grid.block_count(); ++block) extraction.add_block(block);
  return extraction.take();
}

}  // namespace rotunda::recon
