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

// The surface points under directions of a whole lattice, raster order, bitwise equal on identified samples.
// Throws InvalidInput if they are not those of a lattice, or the map is not one of this mesh; so do those below.
std::vector<SurfaceSample> sample_lattice(const TriangleMesh& mesh, const SphereMap& map,
                                          const std::vector<Eigen::Vector3d>& directions);

// Positions and unit normals under a lattice's samples: where a finer colour image is to be coloured.
struct SurfacePoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  // interpolated from the mesh's, or from computed ones if it has none
};
SurfacePoints surface_points(const TriangleMesh& mesh, const SphereMap& map,
                             const std::vector<Eigen::Vector3d>& directions);

// Positions and normals; colours and coverage are left empty for recon/colour to fill. Positions lie beside the surface
// by as much as makes the triangles between them fit it best (lattice_fit.h).
GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, const std::vector<Eigen::Vector3d>& directions);

// The same on the relaxed lattice (relaxed_lattice.h) of a level.
GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, int level = 8);

// The closed surface of the image: border samples joined, chi = 2; normals and colours as the image has them. With
// normals, each cell is cut along the diagonal whose triangles agree better with them.
TriangleMesh remesh(const GeometryImage& image);

// Gives colours to the texels that no camera saw (coverage 0): multi-resolution blending (Burt, Adelson 1983) over the
// nested lattices, continuous across the square's border. Seen texels keep their colour; coverage stays as it is.
void fill_unseen(GeometryImage& image);

}  // namespace rotunda::recon
