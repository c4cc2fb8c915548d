#pragma once
// Meshes as PLY files, read and written by OpenMesh, and OBJ files, read. Positions as they are in the file: world
// frame, metres by custom. Written: binary little-endian, float positions, normals and 8-bit colours (red, green, blue)
// where the mesh has them. Read: ASCII or binary of either byte order; polygons are cut into fans; what else a file
// holds is passed over. Positions go through float in OpenMesh 9, also where the file holds doubles. From any thread.
#include <filesystem>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Throws InvalidInput if there is no such file, std::system_error if it cannot be opened, CorruptData if it is not a PLY,
// ends early, or names a vertex it does not have. Memory stays within a small multiple of the file's size, whatever its
// header claims.
TriangleMesh read_ply(const std::filesystem::path& file);

// The same of a file named .obj as Wavefront OBJ (positions and faces alone), of any other as PLY.
TriangleMesh read_mesh(const std::filesystem::path& file);

// Throws std::system_error if the file cannot be written, InvalidInput if the mesh is not a manifold surface (with or
// without border) or its normals or colours are not one a position.
void write_ply(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace rotunda::recon
