#include "recon/hull/rim_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float kSameSide = 0.5F;  // cosine between a rim's normal and that of a vertex it can belong to
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

// Rims by the cubes of a grid over all of them, side by side in memory.
class RimGrid {
 public:
  RimGrid(std::span<const Rim> rims, float reach) : rims_(rims), reach_(reach) {
    for (const auto& rim : rims) box_.extend(rim.point);
    if (rims.empty()) return;
    constexpr float kMost = 128.0F;
    edge_ = std::max(reach, box_.sizes().maxCoeff() / kMost);
    counts_ = (box_.sizes() / edge_).array().floor().cast<int>() + 1;
    start_.assign(static_cast<std::size_t>(counts_.prod()) + 1, 0);
    for (const auto& rim : rims) ++start_[index(cube_of(rim.point)) + 1];
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    auto next = start_;
    order_.resize(rims.size());
    for (std::uint32_t r = 0; r < rims.size(); ++r) order_[next[index(cube_of(rims[r].point))]++] = r;
  }

  // All rims no farther than the reach that face the same way.
  template <class Visit>
  void for_each_near(const Vector3f& point, const Vector3f& normal, Visit visit) const {
    if (rims_.empty()) return;
    const Vector3i middle = cube_of(point);
    const Vector3i first = (middle.array() - 1).max(0), last = (middle.array() + 1).min(counts_.array() - 1);
    for (int z = first.z(); z <= last.z(); ++z)
      for (int y = first.y(); y <= last.y(); ++y) {
        if (first.x() > last.x()) return;
        const auto from = start_[index({first.x(), y, z})], to = start_[index({last.x(), y, z}) + 1];
        for (auto i = from; i < to; ++i) {
          const auto& rim = rims_[order_[i]];
          const float distance2 = (rim.point - point).squaredNorm();
          if (distance2 <= reach_ * reach_ && rim.normal.dot(normal) > kSameSide)
            visit(order_[i], std::sqrt(distance2));
        }
      }
  }

 private:
  Vector3i cube_of(const Vector3f& p) const {
    const Vector3f cube = (p - box_.min()) / edge_;
    return cube.array().floor().max(-2.0F).min(1000.0F).cast<int>();
  }
  std::size_t index(const Vector3i& c) const {
    return static_cast<std::size_t>(c.x() + counts_.x() * (c.y() + counts_.y() * c.z()));
  }
  std::span<const Rim> rims_;
  float reach_, edge_ = 1.0F;
  Eigen::AlignedBox3f box_;
  Vector3i counts_ = Vector3i::Zero();
  std::vector<std::uint32_t> start_, order_;
};

struct NearestRim {
  float distance = std::numeric_limits<float>::max();
  std::uint32_t rim = kNone;
};

// What the rims near a vertex say of where along its normal the surface is.
struct Pin {
  float offset = 0.0F;  // from the vertex
  float weight = 0.0F;
};

struct NearRims {
  std::vector<NearestRim> nearest;
  std::vector<Pin> pins;
};

NearRims ask_rims(const TriangleMesh& mesh, std::span<const Rim> rims, const RimFitOptions& options) {
  const auto cell = static_cast<float>(options.cell_size);
  const RimGrid grid(rims, 1.5F * cell);
  NearRims near{std::vector<NearestRim>(mesh.positions.size()), std::vector<Pin>(mesh.positions.size())};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    float offsets = 0.0F, weights = 0.0F;
    grid.for_each_near(mesh.positions[v], mesh.normals[v], [&](std::uint32_t r, float distance) {
      const auto& rim = rims[r];
      if (distance < near.nearest[v].distance) near.nearest[v] = {distance, r};
      const float relative = rim.length / static_cast<float>(options.trusted_length);
      const float weight = std::max(0.0F, 1.0F - distance / cell) / (1.0F + relative * relative);
      offsets += weight * rim.normal.dot(rim.point - mesh.positions[v]);
      weights += weight;
    });
    if (weights > 0.0F)
      near.pins[v] = {offsets / weights, std::min(1.0F, weights * static_cast<float>(options.stride))};
  }
  return near;
}

// From the vertices that know a rim on, each takes its neighbours' where that is nearer than its own.
void spread(const TriangleMesh& mesh, const VertexRings& rings, std::span<const Rim> rims, float farthest,
            std::vector<NearestRim>& nearest) {
  using Entry = std::pair<float, std::uint32_t>;  // distance, vertex
  std::vector<Entry> known;
  known.reserve(nearest.size());
  for (std::uint32_t v = 0; v < nearest.size(); ++v)
    if (nearest[v].rim != kNone) known.emplace_back(nearest[v].distance, v);
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue(std::greater<>(), std::move(known));
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > nearest[v].distance) continue;
    for (const auto n : rings[v]) {
      const float from_here = (rims[nearest[v].rim].point - mesh.positions[n]).norm();
      if (from_here >= nearest[n].distance || from_here > farthest) continue;
      nearest[n] = {from_here, nearest[v].rim};
      queue.emplace(from_here, n);
    }
  }
}

float mean_pixel(std::span<const Rim> rims) {
  double sum = 0.0;
  for (const auto& rim : rims) sum += static_cast<double>(rim.pixel);
  return rims.empty() ? 0.0F : static_cast<float>(sum / static_cast<double>(rims.size()));
}

}  // namespace

RimFitOptions rim_fit_options(double cell_size, double metre, int stride) {
  RimFitOptions options;
  options.stride = stride;
  options.cell_size = cell_size;
  options.law.farthest *= metre;
  options.membrane_length *= metre;
  options.trusted_length *= metre;
  return options;
}

std::vector<float> rim_distances(const TriangleMesh& mesh, std::span<const Rim> rims, double cell_size,
                                 double farthest) {
  auto nearest = ask_rims(mesh, rims, {.cell_size = cell_size}).nearest;
  spread(mesh, VertexRings(mesh), rims, static_cast<float>(farthest), nearest);
  std::vector<float> distances(nearest.size());
  for (std::size_t v = 0; v < nearest.size(); ++v)
    distances[v] = std::min(nearest[v].distance, static_cast<float>(farthest));
  return distances;
}

namespace {

// Of a membrane: every vertex wants to be where it settled and beside its neighbours, rims hold it along its normal,
// and it stays inside of the hull. `rest`: the shape whose differences between neighbours cost nothing.
struct Membrane {
  const VertexRings& rings;
  const std::vector<Vector3f>&hull, &normals, &settled, &rest;
  const std::vector<Pin>& pins;  // offsets from the hull
  std::vector<float> screen;
  float pin_weight;

  void relax(std::vector<Vector3f>& positions, int rounds) const {
    for (int round = 0; round < rounds; ++round)
      for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = relaxed(positions, v);
  }

  Vector3f relaxed(const std::vector<Vector3f>& positions, std::size_t v) const {
    Vector3f sum = Vector3f::Zero();
    for (const auto n : rings[v]) sum += positions[n] - rest[n];
    const Vector3f beside = rest[v] + sum / static_cast<float>(rings[v].size());
    const float weight = pin_weight * pins[v].weight, stiff = 1.0F + screen[v];
    const Vector3f free = (beside + screen[v] * settled[v]) / stiff;
    const float along = normals[v].dot(free - hull[v]);
    const float pinned = (along * stiff + weight * pins[v].offset) / (stiff + weight);
    return free + (std::min(pinned, 0.0F) - along) * normals[v];
  }
};

// The membrane evens out over `length`.
std::vector<float> screens(const std::vector<Vector3f>& positions, const VertexRings& rings, double length) {
  std::vector<float> screen(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    float edges = 0.0F;
    for (const auto n : rings[v]) edges += (positions[n] - positions[v]).norm();
    const float relative = edges / static_cast<float>(rings[v].size()) / static_cast<float>(length);
    screen[v] = relative * relative;
  }
  return screen;
}

}  // namespace

void fit_to_rims(TriangleMesh& mesh, std::span<const Rim> rims, const RimFitOptions& options) {
  const VertexRings rings(mesh);
  const auto farthest = static_cast<float>(options.law.farthest);
  auto [nearest, pins] = ask_rims(mesh, rims, options);
  spread(mesh, rings, rims, farthest, nearest);
  const float offset = static_cast<float>(options.law.offset_px) * mean_pixel(rims);
  const auto hull = mesh.positions;
  std::vector<Vector3f> settled(hull.size());
  for (std::size_t v = 0; v < hull.size(); ++v) {
    const float shrink = offset + static_cast<float>(options.law.slope) * std::min(nearest[v].distance, farthest);
    settled[v] = hull[v] - std::max(0.0F, shrink) * mesh.normals[v];
  }
  const std::vector<Vector3f> flat(hull.size(), Vector3f::Zero());
  const Membrane membrane{rings,
                          hull,
                          mesh.normals,
                          settled,
                          flat,
                          pins,
                          screens(hull, rings, options.membrane_length),
                          static_cast<float>(options.pin_weight)};
  mesh.positions = settled;
  membrane.relax(mesh.positions, options.rounds);
}

void pin_to_rims(TriangleMesh& mesh, const TriangleMesh& hull, std::span<const Rim> rims,
                 const RimFitOptions& options) {
  const VertexRings rings(mesh);
  auto pins = ask_rims(mesh, rims, options).pins;
  for (std::size_t v = 0; v < pins.size(); ++v)
    pins[v].offset += hull.normals[v].dot(mesh.positions[v] - hull.positions[v]);
  const auto settled = mesh.positions;
  const Membrane membrane{rings,
                          hull.positions,
                          hull.normals,
                          settled,
                          settled,
                          pins,
                          screens(settled, rings, options.membrane_length),
                          static_cast<float>(options.pin_weight)};
  membrane.relax(mesh.positions, options.rounds);
}

}  // namespace rotunda::recon
