// Prints, for each PLY file given: what the sphere map and the geometry image cost and how good they are.
#include <cstdio>
#include <ctime>

#include "recon/mesh/mesh_file.h"
#include "recon/sphere/progressive_mesh.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_map.h"
#include "tests/support/surface_distance.h"

namespace {

using namespace rotunda::recon;

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const auto mesh = read_ply(argv[i]);
    const double start = cpu_seconds();
    const auto progressive = simplify_to_tetrahedron(mesh);
    const double simplified = cpu_seconds();
    const auto [map, report] = map_to_sphere(mesh);
    const double mapped = cpu_seconds();
    std::printf("%s: %zu triangles\n  progressive mesh %.2f s, sphere map (all) %.2f s CPU, %zu passes; %s\n", argv[i],
                mesh.triangles.size(), simplified - start, mapped - simplified, report.passes, report.failure.c_str());
    std::printf("  flips %zu, |area - 4 pi| %.1e, area/vertex min %.3f p5 %.3f p50 %.3f p95 %.3f, p95/p5 %.2f\n",
                report.flips, report.area_error, report.spread.min, report.spread.p5, report.spread.p50,
                report.spread.p95, report.spread.p95 / report.spread.p5);
    if (!map) continue;
    const double resampling = cpu_seconds();
    const auto image = resample(mesh, *map, 8);
    const double resampled = cpu_seconds();
    const auto error = rotunda::tests::symmetric_distance(mesh, remesh(image), 100000);
    std::printf("  geometry image 257 %.2f s CPU; symmetric error mean %.3f p95 %.2f p99 %.2f max %.1f mm\n",
                resampled - resampling, 1e3 * error.mean, 1e3 * error.p95, 1e3 * error.p99, 1e3 * error.max);
  }
}
