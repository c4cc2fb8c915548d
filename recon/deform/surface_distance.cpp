#include "recon/deform/surface_distance.h"

#include <tbb/parallel_for.h>

#include "config/errors.h"
#include "recon/track/surface_target.h"

namespace rotunda::recon {

std::vector<float> surface_distances(const TriangleMesh& from, const TriangleMesh& onto, double reach) {
  if (from.normals.size() != from.positions.size())
    throw InvalidInput("distances to a surface need the normals of both");
  const SurfaceTarget target(onto);
  std::vector<float> distances(from.positions.size(), static_cast<float>(reach));
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t v) {
    const auto hit = target.closest(from.positions[v].cast<double>(), from.normals[v].cast<double>(), reach);
    if (hit) distances[v] = static_cast<float>(hit->distance);
  });
  return distances;
}

}  // namespace rotunda::recon
