#include "simulator/people/graded_lattice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "config/errors.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using Index = std::array<int, 3>;
constexpr int kBlock = 6;  // samples skipped at once where the surface is far
constexpr std::uint32_t kNone = ~0U;

struct Lattice {
  Vector3d origin;  // of sample (0, 0, 0)
  double cell = 0.0;
  Index cells{};      // along each axis; samples are one more
  CellBox in_coarse;  // of a finer one: where it lies
  int factor = 1;     // of a finer one
  std::vector<float> distance;
  std::vector<std::uint32_t> vertex_of;  // of each cell

  int samples(int axis) const { return cells[static_cast<std::size_t>(axis)] + 1; }
  std::size_t sample(const Index& i) const {
    return (static_cast<std::size_t>(i[2]) * static_cast<std::size_t>(samples(1)) + static_cast<std::size_t>(i[1])) *
               static_cast<std::size_t>(samples(0)) +
           static_cast<std::size_t>(i[0]);
  }
  std::size_t cell_at(const Index& i) const {
    return (static_cast<std::size_t>(i[2]) * static_cast<std::size_t>(cells[1]) + static_cast<std::size_t>(i[1])) *
               static_cast<std::size_t>(cells[0]) +
           static_cast<std::size_t>(i[0]);
  }
  Vector3d point(const Index& i) const { return origin + cell * Vector3d(i[0], i[1], i[2]); }
  bool holds_cell(const Index& i) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (i[a] < 0 || i[a] >= cells[a]) return false;
    return true;
  }
};

Lattice make_lattice(const Vector3d& origin, double cell, const Index& cells) {
  Lattice lattice{.origin = origin, .cell = cell, .cells = cells};
  const auto size = [&](int more) {
    std::size_t product = 1;
    for (const int n : cells) product *= static_cast<std::size_t>(n + more);
    return product;
  };
  lattice.distance.resize(size(1));
  lattice.vertex_of.assign(size(0), kNone);
  return lattice;
}

void fill_block(Lattice& lattice, const DistanceAt& distance, const Index& from) {
  Index end{};
  for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(lattice.cells[a] + 1, from[a] + kBlock);
  const Vector3d low = lattice.point(from), high = lattice.point({end[0] - 1, end[1] - 1, end[2] - 1});
  const double middle = distance(0.5 * (low + high));
  const bool far = std::abs(middle) > 1.5 * (high - low).norm() + 0.03;
  for (Index i = from; i[2] < end[2]; ++i[2])
    for (i[1] = from[1]; i[1] < end[1]; ++i[1])
      for (i[0] = from[0]; i[0] < end[0]; ++i[0])
        lattice.distance[lattice.sample(i)] = static_cast<float>(far ? middle : distance(lattice.point(i)));
}

void fill(Lattice& lattice, const DistanceAt& distance) {
  tbb::parallel_for(0, (lattice.samples(2) + kBlock - 1) / kBlock, [&](int layer) {
    for (int j = 0; j < lattice.samples(1); j += kBlock)
      for (int i = 0; i < lattice.samples(0); i += kBlock) fill_block(lattice, distance, {i, j, layer * kBlock});
  });
}

Index corner_of(const Index& cell, unsigned corner) {
  return {cell[0] + static_cast<int>(corner & 1U), cell[1] + static_cast<int>((corner >> 1) & 1U),
          cell[2] + static_cast<int>(corner >> 2)};
}

template <class Visit>
void for_each_cell(const Lattice& lattice, const Visit& visit) {
  for (int k = 0; k < lattice.cells[2]; ++k)
    for (int j = 0; j < lattice.cells[1]; ++j)
      for (int i = 0; i < lattice.cells[0]; ++i) visit(Index{i, j, k});
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

bool holds_one_sheet(unsigned inside) {
  return edge_connected(inside) && edge_connected(~inside & 0xFFU) && !face_alternates(inside);
}

enum class Border { free, kept };  // kept: a finer lattice shares its border's samples with the coarse one

int from_border(const Lattice& lattice, const Index& i);

// The nearest outer corner joins the body; true if something changed ("well-composed" pictures, Latecki 1997).
bool compose_cell(Lattice& lattice, Border border, const Index& cell) {
  std::array<float*, 8> corner{};
  unsigned inside = 0;
  for (unsigned c = 0; c < 8; ++c) {
    corner[c] = &lattice.distance[lattice.sample(corner_of(cell, c))];
    if (*corner[c] < 0.0F) inside |= 1U << c;
  }
  if (holds_one_sheet(inside)) return false;
  float* nearest = nullptr;
  for (unsigned c = 0; c < 8; ++c) {
    if ((inside >> c) & 1U) continue;
    if (border == Border::kept && from_border(lattice, corner_of(cell, c)) == 0) continue;
    if (nearest == nullptr || *corner[c] < *nearest) nearest = corner[c];
  }
  if (nearest == nullptr) return false;
  *nearest = -2e-4F;
  return true;
}

void make_well_composed(Lattice& lattice, Border border) {
  bool changed = true;
  for (int pass = 0; changed && pass < 20; ++pass) {
    changed = false;
    for_each_cell(lattice, [&](const Index& cell) { changed |= compose_cell(lattice, border, cell); });
  }
}

CellBox box_in(const Lattice& coarse, const FinerBox& finer) {
  CellBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    box.from[a] = std::max(1, static_cast<int>(std::floor((finer.low[axis] - coarse.origin[axis]) / coarse.cell)));
    box.to[a] = std::min(coarse.cells[a] - 1,
                         static_cast<int>(std::ceil((finer.high[axis] - coarse.origin[axis]) / coarse.cell)));
    if (box.from[a] >= box.to[a]) throw InvalidInput("a finer box of the lattice holds no cell");
  }
  return box;
}

// The coarse samples about a fine one, blended (trilinear).
float from_coarse(const Lattice& coarse, const Lattice& fine, const Index& i) {
  Index base{};
  std::array<double, 3> share{};
  for (std::size_t a = 0; a < 3; ++a) {
    base[a] = std::min(fine.in_coarse.from[a] + i[a] / fine.factor, fine.in_coarse.to[a] - 1);
    share[a] = static_cast<double>(i[a]) / fine.factor - (base[a] - fine.in_coarse.from[a]);
  }
  double sum = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    for (std::size_t a = 0; a < 3; ++a) weight *= ((corner >> a) & 1U) ? share[a] : 1.0 - share[a];
    if (weight > 0.0) sum += weight * coarse.distance[coarse.sample(corner_of(base, corner))];
  }
  return static_cast<float>(sum);
}

// Fine cells from a sample to the border.
int from_border(const Lattice& lattice, const Index& i) {
  int least = i[0];
  for (std::size_t a = 0; a < 3; ++a) least = std::min({least, i[a], lattice.cells[a] - i[a]});
  return least;
}

// On the border the fine lattice knows only what the coarse one does: then each coarse cell that adjoins it still holds
// one sheet. Within a coarse cell of it the two are blended: a step between them could leave a cell with two sheets.
void share_border(const Lattice& coarse, Lattice& fine) {
  for (Index i{}; i[2] < fine.samples(2); ++i[2])
    for (i[1] = 0; i[1] < fine.samples(1); ++i[1])
      for (i[0] = 0; i[0] < fine.samples(0); ++i[0]) {
        const float own = std::min(1.0F, static_cast<float>(from_border(fine, i)) / static_cast<float>(fine.factor));
        float& distance = fine.distance[fine.sample(i)];
        if (own < 1.0F) distance = own * distance + (1.0F - own) * from_coarse(coarse, fine, i);
      }
}

Lattice make_finer(const Lattice& coarse, const FinerBox& finer, const DistanceAt& distance) {
  const CellBox box = box_in(coarse, finer);
  Index cells{};
  for (std::size_t a = 0; a < 3; ++a) cells[a] = (box.to[a] - box.from[a]) * finer.factor;
  Lattice fine = make_lattice(coarse.point(box.from), coarse.cell / finer.factor, cells);
  fine.in_coarse = box;
  fine.factor = finer.factor;
  fill(fine, distance);
  share_border(coarse, fine);
  make_well_composed(fine, Border::kept);
  return fine;
}

class Contour {
 public:
  Contour(Lattice coarse, std::vector<Lattice> finer) : coarse_(std::move(coarse)), finer_(std::move(finer)) {}

  recon::TriangleMesh mesh() {
    for_each_edge(coarse_, [&](const Index& i, std::size_t axis) {
      if (!is_in_finer(i, axis)) cross(coarse_, i, axis);
    });
    for (auto& fine : finer_) for_each_edge(fine, [&](const Index& i, std::size_t axis) { cross(fine, i, axis); });
    recon::TriangleMesh mesh;
    for (std::size_t v = 0; v < sum_.size(); ++v)
      mesh.positions.push_back((sum_[v] / static_cast<double>(count_[v])).cast<float>());
    for (const auto& quad : quads_) add_polygon(mesh, quad);
    return mesh;
  }

 private:
  template <class Visit>
  static void for_each_edge(const Lattice& lattice, const Visit& visit) {
    for (int k = 0; k < lattice.samples(2); ++k)
      for (int j = 0; j < lattice.samples(1); ++j)
        for (int i = 0; i < lattice.samples(0); ++i)
          for (std::size_t axis = 0; axis < 3; ++axis) {
            Index far{i, j, k};
            if (++far[axis] > lattice.cells[axis]) continue;
            const bool in = lattice.distance[lattice.sample({i, j, k})] < 0.0F;
            if (in != (lattice.distance[lattice.sample(far)] < 0.0F)) visit(Index{i, j, k}, axis);
          }
  }

  // In or on the border of a finer box: its own edges stand for this one.
  bool is_in_finer(const Index& i, std::size_t axis) const {
    return std::any_of(finer_.begin(), finer_.end(), [&](const Lattice& fine) {
      const CellBox& box = fine.in_coarse;
      for (std::size_t a = 0; a < 3; ++a)
        if (i[a] < box.from[a] || i[a] + (a == axis ? 1 : 0) > box.to[a]) return false;
      return true;
    });
  }

  // The vertex number of the cell of `lattice` at `i`, or of the coarse cell there if that lies outside.
  std::uint32_t vertex_in(Lattice& lattice, Index i, const Vector3d& crossing) {
    Lattice* owner = &lattice;
    if (!lattice.holds_cell(i)) {
      if (&lattice == &coarse_) return kNone;
      for (std::size_t a = 0; a < 3; ++a)
        i[a] = lattice.in_coarse.from[a] + static_cast<int>(std::floor(static_cast<double>(i[a]) / lattice.factor));
      owner = &coarse_;
      if (!coarse_.holds_cell(i)) return kNone;
    }
    std::uint32_t& vertex = owner->vertex_of[owner->cell_at(i)];
    if (vertex == kNone) {
      vertex = static_cast<std::uint32_t>(sum_.size());
      sum_.emplace_back(Vector3d::Zero());
      count_.push_back(0);
    }
    sum_[vertex] += crossing;
    ++count_[vertex];
    return vertex;
  }

  // The four cells about an edge that crosses the surface are joined.
  void cross(Lattice& lattice, const Index& i, std::size_t axis) {
    Index far = i;
    ++far[axis];
    const double d0 = lattice.distance[lattice.sample(i)], d1 = lattice.distance[lattice.sample(far)];
    const double t = d0 / (d0 - d1);
    const Vector3d crossing = (1.0 - t) * lattice.point(i) + t * lattice.point(far);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<std::uint32_t, 4> quad{};
    constexpr std::array<std::array<int, 2>, 4> kAround = {{{1, 1}, {0, 1}, {0, 0}, {1, 0}}};
    for (std::size_t n = 0; n < 4; ++n) {
      Index cell = i;
      cell[u] -= kAround[n][0];
      cell[v] -= kAround[n][1];
      quad[n] = vertex_in(lattice, cell, crossing);
      if (quad[n] == kNone) return;
    }
    if (!(d0 < 0.0)) std::swap(quad[1], quad[3]);
    quads_.push_back(quad);
  }

  // Two corners of a quad may be one coarse cell's: then it is a triangle.
  static void add_polygon(recon::TriangleMesh& mesh, const std::array<std::uint32_t, 4>& quad) {
    std::vector<std::uint32_t> ring;
    for (const auto vertex : quad)
      if (ring.empty() || (ring.back() != vertex && ring.front() != vertex)) ring.push_back(vertex);
    if (ring.size() < 3) return;
    if (ring.size() == 3) {
      mesh.triangles.push_back({ring[0], ring[1], ring[2]});
      return;
    }
    const auto length = [&](std::size_t a, std::size_t b) {
      return (mesh.positions[ring[a]] - mesh.positions[ring[b]]).norm();
    };
    const std::size_t s = length(0, 2) <= length(1, 3) ? 0 : 1;
    mesh.triangles.push_back({ring[s], ring[s + 1], ring[s + 2]});
    mesh.triangles.push_back({ring[s], ring[s + 2], ring[(s + 3) % 4]});
  }

  Lattice coarse_;
  std::vector<Lattice> finer_;
  std::vector<Vector3d> sum_;  // of the crossings about each cell with a vertex
  std::vector<int> count_;
  std::vector<std::array<std::uint32_t, 4>> quads_;
};

}  // namespace

recon::TriangleMesh contour(const DistanceAt& distance, const GradedLatticeOptions& options) {
  Index cells{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    cells[a] = static_cast<int>(std::ceil((options.high[axis] - options.low[axis]) / options.cell));
    if (cells[a] < 1) throw InvalidInput("the lattice holds no cell");
  }
  Lattice coarse = make_lattice(options.low, options.cell, cells);
  fill(coarse, distance);
  make_well_composed(coarse, Border::free);
  std::vector<Lattice> finer;
  for (const auto& box : options.finer) finer.push_back(make_finer(coarse, box, distance));
  return Contour(std::move(coarse), std::move(finer)).mesh();
}

}  // namespace rotunda::simulator
