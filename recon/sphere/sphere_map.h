#pragma once
// Sphere map (Praun, Hoppe 2003): a closed genus-0 mesh mapped one-to-one onto the unit sphere. The mesh is simplified
// to a tetrahedron; its vertices come back one by one, each inside the kernel of its 1-ring, so that no spherical
// triangle is ever flipped; in between the map is relaxed for an even density of vertices (ALGORITHMS.md step 5,
// eq. (1)-(2)), each coarse vertex claiming room for all the fine vertices it stands for.
// Pure; the same result on any number of threads. Directions are unit vectors, double, in the frame of the mesh.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct SphereMap {
  std::vector<Eigen::Vector3d> points;  // unit; one per vertex of the mesh, +z for vertices without a triangle
};

struct SphereMapOptions {
  double growth = 1.7;        // relax again when the count of vertices has grown by this factor ...
  double early_growth = 1.3;  // ... and below 1000 vertices
  int passes = 30;            // over the vertices at each relaxation, at most
  double still = 0.01;        // a vertex rests when it moves by less than this share of its mean edge
};

// Spherical area per vertex (a third of its triangles), as a share of the mean 4 pi / V.
struct AreaSpread {
  double min = 0.0, p5 = 0.0, p50 = 0.0, p95 = 0.0;
};

struct SphereMapReport {
  std::size_t flips = 0;    // spherical triangles that are not counter-clockwise (exact predicate)
  std::size_t splits = 0;   // vertices inserted
  std::size_t passes = 0;   // relaxation passes over all levels
  double area_error = 0.0;  // |sum of spherical areas - 4 pi|, steradians
  AreaSpread spread;
  std::string failure;  // why there is no map; empty if there is one
};

struct SphereMapResult {
  std::optional<SphereMap> map;  // only if flips == 0 and area_error <= 1e-9: then it is one-to-one
  SphereMapReport report;
};

// Any mesh may be given; one that is no sphere, or has wild indices or positions, gets a report with the failure.
SphereMapResult map_to_sphere(const TriangleMesh& mesh, const SphereMapOptions& options = {});

// Triangles whose image is not counter-clockwise from outside, by the exact predicate.
std::size_t flipped_triangles(const TriangleMesh& mesh, const SphereMap& map);
double spherical_area(const TriangleMesh& mesh, const SphereMap& map);  // 4 pi for a one-to-one map
AreaSpread area_spread(const TriangleMesh& mesh, const SphereMap& map);

// The map turned as a whole so that its directions agree best with the mesh's normals, weighted by area (Horn 1987).
// map_to_sphere has done so already.
SphereMap align_to_normals(const TriangleMesh& mesh, const SphereMap& map);

// The map turned so that it carries surface points near those of the previous frame to their old directions; keeps a
// sequence from spinning. Both meshes in one frame of reference, metres.
SphereMap align_to(const TriangleMesh& mesh, const SphereMap& map, const TriangleMesh& previous_mesh,
                   const SphereMap& previous_map);

}  // namespace rotunda::recon
