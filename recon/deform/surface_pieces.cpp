#include "recon/deform/surface_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

namespace rotunda::recon {
namespace {

using Eigen::Vector3f;

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

double area_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Vector3f& a = mesh.positions[t[0]];
  return 0.5 * static_cast<double>((mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).norm());
}

// Vertices by the cell they lie in.
class VertexGrid {
 public:
  VertexGrid(const TriangleMesh& mesh, double cell) : mesh_(mesh), cell_(static_cast<float>(cell)) {}
  void add(std::uint32_t v) { cells_[cell_of(mesh_.positions[v])].push_back(v); }
  struct Found {
    std::uint32_t vertex = 0;
    float distance = 0.0F;
  };
  std::optional<Found> nearest(const Vector3f& p) const {  // within a cell's edge
    std::optional<Found> found;
    const auto centre = cell_of(p);
    for (int i = 0; i < 27; ++i) {
      const auto cell = cells_.find({centre[0] + i % 3 - 1, centre[1] + i / 3 % 3 - 1, centre[2] + i / 9 - 1});
      if (cell == cells_.end()) continue;
      for (const auto v : cell->second)
        if (const float d = (mesh_.positions[v] - p).norm(); d <= cell_ && (!found || d < found->distance))
          found = Found{v, d};
    }
    return found;
  }

 private:
  using Cell = std::array<int, 3>;
  Cell cell_of(const Vector3f& p) const {
    const Eigen::Array3f c = (p.array() / cell_).floor();
    return {static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z())};
  }
  const TriangleMesh& mesh_;
  float cell_;
  std::map<Cell, std::vector<std::uint32_t>> cells_;
};

struct Bridge {
  std::uint32_t from, to;
  float length;
};

// The shortest ways from a piece's vertices to those in the grid: all that are little longer than the shortest.
std::vector<Bridge> bridges_from(const TriangleMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                 const VertexGrid& joined) {
  constexpr std::size_t kTried = 4000, kMost = 64;
  constexpr float kLonger = 0.01F;
  std::vector<Bridge> bridges;
  const std::size_t step = std::max<std::size_t>(1, vertices.size() / kTried);
  for (std::size_t i = 0; i < vertices.size(); i += step)
    if (const auto found = joined.nearest(mesh.positions[vertices[i]]))
      bridges.push_back({vertices[i], found->vertex, found->distance});
  if (bridges.empty()) return bridges;
  const float least = std::min_element(bridges.begin(), bridges.end(), [](const Bridge& a, const Bridge& b) {
                        return a.length < b.length;
                      })->length;
  std::erase_if(bridges, [&](const Bridge& bridge) { return bridge.length > least + kLonger; });
  const std::size_t every = (bridges.size() + kMost - 1) / kMost;
  std::vector<Bridge> chosen;
  for (std::size_t i = 0; i < bridges.size(); i += every) chosen.push_back(bridges[i]);
  return chosen;
}

}  // namespace

SurfacePieces pieces_of(const TriangleMesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  std::vector<std::uint32_t> parent(vertices);
  std::iota(parent.begin(), parent.end(), 0U);
  for (const auto& [a, b, c] : mesh.triangles) {
    parent[root_of(parent, b)] = root_of(parent, a);
    parent[root_of(parent, c)] = root_of(parent, a);
  }
  std::vector<double> area(vertices, 0.0);
  for (const auto& t : mesh.triangles) area[root_of(parent, t[0])] += area_of(mesh, t);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t v = 0; v < vertices; ++v)
    if (root_of(parent, v) == v) roots.push_back(v);
  std::stable_sort(roots.begin(), roots.end(), [&](auto a, auto b) { return area[a] > area[b]; });
  SurfacePieces pieces;
  std::vector<std::uint32_t> number(vertices);
  for (std::uint32_t i = 0; i < roots.size(); ++i) {
    number[roots[i]] = i;
    pieces.areas.push_back(area[roots[i]]);
  }
  for (std::uint32_t v = 0; v < vertices; ++v) pieces.piece.push_back(number[root_of(parent, v)]);
  return pieces;
}

PieceBridges bridge_pieces(const TriangleMesh& mesh, const SurfacePieces& pieces, double reach) {
  PieceBridges result;
  std::vector<std::vector<std::uint32_t>> vertices(pieces.areas.size());
  for (std::uint32_t v = 0; v < pieces.piece.size(); ++v) vertices[pieces.piece[v]].push_back(v);
  std::vector<std::uint32_t> neighbour(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) neighbour[t[k]] = t[(k + 1) % 3];
  VertexGrid joined(mesh, reach);
  for (const auto v : vertices[0]) joined.add(v);
  std::vector<std::uint32_t> waiting(pieces.areas.size() - 1);
  std::iota(waiting.begin(), waiting.end(), 1U);
  for (bool progress = true; progress && !waiting.empty();) {
    progress = false;
    for (auto& piece : waiting) {
      const auto bridges = bridges_from(mesh, vertices[piece], joined);
      if (bridges.empty()) continue;
      for (const auto& bridge : bridges) {
        result.triangles.push_back({bridge.from, neighbour[bridge.from], bridge.to});
        result.widest = std::max(result.widest, static_cast<double>(bridge.length));
      }
      for (const auto v : vertices[piece]) joined.add(v);
      piece = 0;  // joined
      progress = true;
    }
    std::erase(waiting, 0U);
  }
  result.apart = waiting;
  return result;
}

}  // namespace rotunda::recon
