#include "recon/track/rest_shape.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "recon/track/surface_smoothing.h"

namespace rotunda::recon {
namespace {

constexpr double kGate = 0.06;  // metres: as much as clothes and hair stand off what was thought
constexpr double kQuantile = 0.5;
constexpr int kSweeps = 3;

}  // namespace

void RestShape::add(const TriangleMesh& carried, const SurfaceTarget& target) {
  std::vector<float> offsets(carried.positions.size(), std::numeric_limits<float>::quiet_NaN());
  tbb::parallel_for(std::size_t{0}, offsets.size(), [&](std::size_t i) {
    const Eigen::Vector3d at = carried.positions[i].cast<double>(), normal = carried.normals[i].cast<double>();
    const auto hit = target.closest(at, normal, kGate);
    if (hit) offsets[i] = static_cast<float>(normal.dot(hit->point - at));
  });
  offsets_.push_back(std::move(offsets));
}

TriangleMesh RestShape::refined() const {
  if (offsets_.size() < kFewest) return key_;
  std::vector<double> chosen(key_.positions.size(), 0.0);
  tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t i) {
    std::vector<float> all;
    for (const auto& frame : offsets_)
      if (!std::isnan(frame[i])) all.push_back(frame[i]);
    if (all.size() < kFewest) return;
    const auto low = all.begin() + static_cast<long>(kQuantile * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), low, all.end());
    chosen[i] = *low;
  });
  even_out(VertexRings(key_), kSweeps, chosen);
  auto refined = key_;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    refined.positions[i] += static_cast<float>(chosen[i]) * key_.normals[i];
  compute_normals(refined);
  return refined;
}

}  // namespace rotunda::recon
