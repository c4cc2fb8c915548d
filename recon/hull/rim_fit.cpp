#include "recon/hull/rim_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

constexpr float kSameSide = 0.5F;  // cosine between a rim's normal and that of a vertex it can belong to
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

// Rims by cubes of edge `reach`.
class RimCubes {
 public:
  RimCubes(std::span<const Rim> rims, double reach) : rims_(rims), reach_(static_cast<float>(reach)) {
    for (std::uint32_t i = 0; i < rims.size(); ++i) cubes_[key(cube_of(rims[i].point))].push_back(i);
  }
  // All rims no farther than the reach that face the same way.
  template <class Visit>
  void for_each_near(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, Visit visit) const {
    const Eigen::Vector3i middle = cube_of(point);
    for (int i = 0; i < 27; ++i) {
      const auto found = cubes_.find(key(middle + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (found == cubes_.end()) continue;
      for (const auto r : found->second) {
        const float distance = (rims_[r].point - point).norm();
        if (distance <= reach_ && rims_[r].normal.dot(normal) > kSameSide) visit(r, distance);
      }
    }
  }

 private:
  Eigen::Vector3i cube_of(const Eigen::Vector3f& p) const { return (p / reach_).array().floor().cast<int>(); }
  static std::uint64_t key(const Eigen::Vector3i& c) {
    const auto part = [](int n) { return static_cast<std::uint64_t>(n + (1 << 20)) & 0x1FFFFFU; };
    return part(c.x()) | (part(c.y()) << 21) | (part(c.z()) << 42);
  }
  std::span<const Rim> rims_;
  float reach_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;
};

struct NearestRim {
  float distance = std::numeric_limits<float>::max();
  std::uint32_t rim = kNone;
};

// Vertices near a rim know it; from them on, each takes its neighbours' rim where that is nearer than its own.
std::vector<NearestRim> nearest_rims(const TriangleMesh& mesh, const VertexRings& rings, std::span<const Rim> rims,
                                     const RimCubes& cubes, float farthest) {
  using Entry = std::pair<float, std::uint32_t>;  // distance, vertex
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<NearestRim> nearest(mesh.positions.size());
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    cubes.for_each_near(mesh.positions[v], mesh.normals[v], [&](std::uint32_t r, float distance) {
      if (distance < nearest[v].distance) nearest[v] = {distance, r};
    });
    if (nearest[v].rim != kNone) queue.emplace(nearest[v].distance, v);
  }
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
  return nearest;
}

// What the rims near a vertex say of where along its normal the surface is.
struct Pin {
  float offset = 0.0F;  // from the vertex
  float weight = 0.0F;
};

std::vector<Pin> pins_of(const TriangleMesh& mesh, std::span<const Rim> rims, const RimCubes& cubes,
                         const RimFitOptions& options) {
  std::vector<Pin> pins(mesh.positions.size());
  const auto reach = static_cast<float>(options.cell_size);
  for (std::size_t v = 0; v < pins.size(); ++v) {
    float offsets = 0.0F, weights = 0.0F;
    cubes.for_each_near(mesh.positions[v], mesh.normals[v], [&](std::uint32_t r, float distance) {
      const float relative = rims[r].length / static_cast<float>(options.trusted_length);
      const float near = std::max(0.0F, 1.0F - distance / reach);
      const float weight = near / (1.0F + relative * relative);
      offsets += weight * rims[r].normal.dot(rims[r].point - mesh.positions[v]);
      weights += weight;
    });
    if (weights > 0.0F) pins[v] = {offsets / weights, std::min(1.0F, weights * static_cast<float>(options.stride))};
  }
  return pins;
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
  const RimCubes cubes(rims, 1.5 * cell_size);
  const auto nearest = nearest_rims(mesh, VertexRings(mesh), rims, cubes, static_cast<float>(farthest));
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
  const std::vector<Eigen::Vector3f>&hull, &normals, &settled, &rest;
  const std::vector<Pin>& pins;  // offsets from the hull
  std::vector<float> screen;
  float pin_weight;

  void relax(std::vector<Eigen::Vector3f>& positions, int rounds) const {
    for (int round = 0; round < rounds; ++round)
      for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = relaxed(positions, v);
  }

  Eigen::Vector3f relaxed(const std::vector<Eigen::Vector3f>& positions, std::size_t v) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const auto n : rings[v]) sum += positions[n] - rest[n];
    const Eigen::Vector3f beside = rest[v] + sum / static_cast<float>(rings[v].size());
    const float weight = pin_weight * pins[v].weight, stiff = 1.0F + screen[v];
    const Eigen::Vector3f free = (beside + screen[v] * settled[v]) / stiff;
    const float along = normals[v].dot(free - hull[v]);
    const float pinned = (along * stiff + weight * pins[v].offset) / (stiff + weight);
    return free + (std::min(pinned, 0.0F) - along) * normals[v];
  }
};

// The membrane evens out over `length`.
std::vector<float> screens(const std::vector<Eigen::Vector3f>& positions, const VertexRings& rings, double length) {
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
  const RimCubes cubes(rims, 1.5 * options.cell_size);
  const auto farthest = static_cast<float>(options.law.farthest);
  const auto nearest = nearest_rims(mesh, rings, rims, cubes, farthest);
  const float offset = static_cast<float>(options.law.offset_px) * mean_pixel(rims);
  const auto hull = mesh.positions;
  std::vector<Eigen::Vector3f> settled(hull.size());
  for (std::size_t v = 0; v < hull.size(); ++v) {
    const float shrink = offset + static_cast<float>(options.law.slope) * std::min(nearest[v].distance, farthest);
    settled[v] = hull[v] - std::max(0.0F, shrink) * mesh.normals[v];
  }
  const std::vector<Eigen::Vector3f> flat(hull.size(), Eigen::Vector3f::Zero());
  const auto pins = pins_of(mesh, rims, cubes, options);
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
  auto pins = pins_of(mesh, rims, RimCubes(rims, 1.5 * options.cell_size), options);
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
