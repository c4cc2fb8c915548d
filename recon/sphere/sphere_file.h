#pragma once
// A sphere map as a PLY mesh: the mesh's vertices on the unit sphere in its order, ASCII, double, 17 digits, so that
// whoever checks it for flipped triangles sees exactly what was computed; with the mesh's triangles.
#include <filesystem>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// Throws std::system_error if the file cannot be written, InvalidInput if the map is not one of this mesh.
void write_sphere_ply(const std::filesystem::path& file, const TriangleMesh& mesh, const SphereMap& map);

}  // namespace rotunda::recon
