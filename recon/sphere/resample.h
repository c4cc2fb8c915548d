#pragma once
// Mapped mesh -> geometry image -> mesh (ALGORITHMS.md step 6): the surface read at the samples of the closed
// octahedral lattice through the sphere map. World frame, metres. The map must be one-to-one (map_to_sphere).
#include <Eigen/Core>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/geometry_image.h"
#include "recon/sphere/sphere_locator.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// The surface points under the lattice's samples, raster order, bitwise equal on identified samples.
std::vector<SurfaceSample> sample_lattice(const TriangleMesh& mesh, const SphereMap& map, int level);

// Positions and unit normals under the lattice's samples: where a finer colour image is to be coloured.
struct SurfacePoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  // interpolated from the mesh's, or from computed ones if it has none
};
SurfacePoints surface_points(const TriangleMesh& mesh, const SphereMap& map, int level);

// Positions and normals at `level`; colours and coverage are left empty for recon/colour to fill.
// Throws InvalidInput if level is out of range or the map is not one of this mesh.
GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, int level = 8);

// The closed surface of the image: border samples joined, chi = 2; normals and colours as the image has them.
TriangleMesh remesh(const GeometryImage& image);

// Gives colours to the texels that no camera saw (coverage 0): multi-resolution blending (Burt, Adelson 1983) over the
// nested lattices, continuous across the square's border. Seen texels keep their colour; coverage stays as it is.
void fill_unseen(GeometryImage& image);

}  // namespace rotunda::recon
