#include "simulator/people/body_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
constexpr int kBlock = 6;  // grid cells skipped at once where the surface is far
constexpr std::uint32_t kNone = ~0U;

// Grid lines of one axis: `coarse` apart, `fine` between the given limits.
std::vector<double> grid_lines(double from, double to, double coarse, double fine,
                               const std::vector<std::pair<double, double>>& fine_ranges) {
  std::vector<double> lines{from};
  while (lines.back() < to) {
    const double x = lines.back();
    const bool is_fine = std::any_of(fine_ranges.begin(), fine_ranges.end(),
                                     [&](const auto& range) { return x >= range.first && x < range.second; });
    lines.push_back(x + (is_fine ? fine : coarse));
  }
  return lines;
}

struct Grid {
  std::vector<double> x, y, z;
  std::vector<float> distance;

  std::size_t at(std::size_t i, std::size_t j, std::size_t k) const { return (k * y.size() + j) * x.size() + i; }
  Vector3d point(std::size_t i, std::size_t j, std::size_t k) const { return {x[i], y[j], z[k]}; }
};

Grid make_grid(const Skeleton& skeleton, double c) {
  const double h = skeleton.height;
  const Vector3d wrist = skeleton.joint[index(Joint::hand_left)];
  const double reach = wrist.y() + 0.11 * h, palm = wrist.y() - 0.01 * h;
  Grid grid;
  grid.x = grid_lines(-0.14 * h, 0.16 * h, 0.0100 * c, 0.0080 * c, {{0.02 * h, 0.08 * h}});
  grid.y = grid_lines(-reach, reach, 0.0120 * c, 0.0085 * c, {{-reach, -palm}, {-0.055 * h, 0.055 * h}, {palm, reach}});
  grid.z = grid_lines(-0.02, 1.03 * h, 0.0120 * c, 0.0075 * c, {{0.85 * h, 1.02 * h}});
  grid.distance.resize(grid.x.size() * grid.y.size() * grid.z.size());
  return grid;
}

void fill_block(Grid& grid, const BodyShape& shape, std::array<std::size_t, 3> from) {
  const auto end = [](const std::vector<double>& lines, std::size_t start) {
    return std::min(lines.size(), start + kBlock);
  };
  const std::size_t i1 = end(grid.x, from[0]), j1 = end(grid.y, from[1]), k1 = end(grid.z, from[2]);
  const Vector3d low = grid.point(from[0], from[1], from[2]), high = grid.point(i1 - 1, j1 - 1, k1 - 1);
  const double middle = shape.distance(0.5 * (low + high));
  const bool far = std::abs(middle) > 1.5 * (high - low).norm() + 0.03;
  for (std::size_t k = from[2]; k < k1; ++k)
    for (std::size_t j = from[1]; j < j1; ++j)
      for (std::size_t i = from[0]; i < i1; ++i)
        grid.distance[grid.at(i, j, k)] = static_cast<float>(far ? middle : shape.distance(grid.point(i, j, k)));
}

void fill(Grid& grid, const BodyShape& shape) {
  const std::size_t layers = (grid.z.size() + kBlock - 1) / kBlock;
  tbb::parallel_for(std::size_t{0}, layers, [&](std::size_t layer) {
    for (std::size_t j = 0; j < grid.y.size(); j += kBlock)
      for (std::size_t i = 0; i < grid.x.size(); i += kBlock) fill_block(grid, shape, {i, j, layer * kBlock});
  });
}

// Corners of a cell: bit 0 along x, bit 1 along y, bit 2 along z. True if the corners in `set` hang together by edges.
bool edge_connected(unsigned set) {
  if (set == 0) return true;
  unsigned reached = set & (~set + 1), before = 0;
  while (reached != before) {
    before = reached;
    for (unsigned c = 0; c < 8; ++c)
      if (reached & (1U << c)) reached |= ((1U << (c ^ 1U)) | (1U << (c ^ 2U)) | (1U << (c ^ 4U))) & set;
  }
  return reached == set;
}

// The surface passes a face twice if its corners' signs alternate.
bool face_alternates(unsigned inside) {
  constexpr std::array<std::array<unsigned, 4>, 6> kFaces = {
      {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}};
  return std::any_of(kFaces.begin(), kFaces.end(), [&](const auto& face) {
    const auto in = [&](std::size_t i) { return (inside >> face[i]) & 1U; };
    return in(0) == in(2) && in(1) == in(3) && in(0) != in(1);
  });
}

// Cells that hold more than one sheet would give a surface that touches itself: their nearest outer
// corner joins the body until there is none ("well-composed" pictures, Latecki 1997). Moves the surface by less than a
// cell.
void make_well_composed(Grid& grid) {
  bool changed = true;
  for (int pass = 0; changed && pass < 20; ++pass) {
    changed = false;
    for (std::size_t k = 0; k + 1 < grid.z.size(); ++k)
      for (std::size_t j = 0; j + 1 < grid.y.size(); ++j)
        for (std::size_t i = 0; i + 1 < grid.x.size(); ++i) {
          std::array<float*, 8> corner{};
          unsigned inside = 0;
          for (unsigned c = 0; c < 8; ++c) {
            corner[c] = &grid.distance[grid.at(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2))];
            if (*corner[c] < 0.0F) inside |= 1U << c;
          }
          if (edge_connected(inside) && edge_connected(~inside & 0xFFU) && !face_alternates(inside)) continue;
          float& nearest = **std::min_element(corner.begin(), corner.end(), [](const float* p, const float* q) {
            return (*p < 0.0F ? 1e9F : *p) < (*q < 0.0F ? 1e9F : *q);
          });
          nearest = -2e-4F;
          changed = true;
        }
  }
}

// The mean of the points where the edges of the cell (i, j, k) cross the surface; false if none does.
bool dual_vertex(const Grid& grid, std::size_t i, std::size_t j, std::size_t k, Vector3d& vertex) {
  Vector3d sum = Vector3d::Zero();
  int crossings = 0;
  for (unsigned corner = 0; corner < 8; ++corner)
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (corner & (1U << axis)) continue;
      const unsigned other = corner | (1U << axis);
      const auto place = [&](unsigned c) {
        return std::array<std::size_t, 3>{i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2)};
      };
      const auto a = place(corner), b = place(other);
      const double da = grid.distance[grid.at(a[0], a[1], a[2])], db = grid.distance[grid.at(b[0], b[1], b[2])];
      if ((da < 0.0) == (db < 0.0)) continue;
      const double t = da / (da - db);
      sum += (1.0 - t) * grid.point(a[0], a[1], a[2]) + t * grid.point(b[0], b[1], b[2]);
      ++crossings;
    }
  if (crossings == 0) return false;
  vertex = sum / crossings;
  return true;
}

void add_quad(recon::TriangleMesh& mesh, std::array<std::uint32_t, 4> q, bool flip) {
  if (flip) std::swap(q[1], q[3]);
  const auto length = [&](int a, int b) {
    return (mesh.positions[q[static_cast<std::size_t>(a)]] - mesh.positions[q[static_cast<std::size_t>(b)]]).norm();
  };
  if (length(0, 2) <= length(1, 3)) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  } else {
    mesh.triangles.push_back({q[1], q[2], q[3]});
    mesh.triangles.push_back({q[1], q[3], q[0]});
  }
}

std::vector<std::uint32_t> place_vertices(const Grid& grid, recon::TriangleMesh& mesh) {
  std::vector<std::uint32_t> vertex_of(grid.distance.size(), kNone);
  Vector3d vertex;
  for (std::size_t k = 0; k + 1 < grid.z.size(); ++k)
    for (std::size_t j = 0; j + 1 < grid.y.size(); ++j)
      for (std::size_t i = 0; i + 1 < grid.x.size(); ++i)
        if (dual_vertex(grid, i, j, k, vertex)) {
          vertex_of[grid.at(i, j, k)] = static_cast<std::uint32_t>(mesh.positions.size());
          mesh.positions.push_back(vertex.cast<float>());
        }
  return vertex_of;
}

// A quad for each grid edge that crosses the surface, from the four cells about it.
void join_vertices(const Grid& grid, const std::vector<std::uint32_t>& vertex_of, recon::TriangleMesh& mesh) {
  const std::array<std::size_t, 3> stride{1, grid.x.size(), grid.x.size() * grid.y.size()};
  for (std::size_t k = 1; k + 1 < grid.z.size(); ++k)
    for (std::size_t j = 1; j + 1 < grid.y.size(); ++j)
      for (std::size_t i = 1; i + 1 < grid.x.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t here = grid.at(i, j, k);
          const bool inside = grid.distance[here] < 0.0F;
          if (inside == (grid.distance[here + stride[axis]] < 0.0F)) continue;
          const std::size_t u = stride[(axis + 1) % 3], v = stride[(axis + 2) % 3];
          add_quad(mesh, {vertex_of[here - u - v], vertex_of[here - v], vertex_of[here], vertex_of[here - u]}, !inside);
        }
}

Vector3d onto_surface(const BodyShape& shape, Vector3d p) {
  for (int step = 0; step < 2; ++step) {
    const Vector3d g = shape.gradient(p);
    const double slope = std::max(g.norm(), 0.3);
    p -= g / slope * std::clamp(shape.distance(p) / slope, -0.006, 0.006);
  }
  return p;
}

// Evens the triangles out along the surface, then draws the vertices onto it.
void relax(const BodyShape& shape, recon::TriangleMesh& mesh,
           const std::vector<std::vector<std::uint32_t>>& neighbours) {
  const auto before = mesh.positions;
  tbb::parallel_for(std::size_t{0}, before.size(), [&](std::size_t v) {
    Vector3d mean = Vector3d::Zero();
    for (const auto n : neighbours[v]) mean += before[n].cast<double>();
    mean /= static_cast<double>(neighbours[v].size());
    const Vector3d here = before[v].cast<double>();
    mesh.positions[v] = onto_surface(shape, here + 0.5 * (mean - here)).cast<float>();
  });
}

}  // namespace

std::vector<std::vector<std::uint32_t>> neighbours_of(const recon::TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) neighbours[t[i]].push_back(t[(i + 1) % 3]);
  return neighbours;
}

recon::TriangleMesh body_mesh(const BodyShape& shape, const Skeleton& skeleton, double coarseness) {
  Grid grid = make_grid(skeleton, coarseness);
  fill(grid, shape);
  make_well_composed(grid);
  recon::TriangleMesh mesh;
  join_vertices(grid, place_vertices(grid, mesh), mesh);
  const auto topology = recon::topology_of(mesh);
  if (!topology.is_sphere())
    throw InvalidInput(
        fmt::format("this build gives a body of {} pieces with Euler characteristic {}, not one closed "
                    "surface; choose milder proportions",
                    topology.components, topology.euler_characteristic));
  const auto neighbours = neighbours_of(mesh);
  for (int round = 0; round < 3; ++round) relax(shape, mesh, neighbours);
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
