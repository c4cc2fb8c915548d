#pragma once
// Scans of people as scanners and programs write them: PLY with colours at the vertices or a picture (`comment
// TextureFile`, coordinates at corners or vertices), OBJ with its materials, glTF 2.0 (.glb, .gltf). Pictures are PNG
// or JPEG; what they show comes to the vertices (textured_mesh.h). Frame and unit are the file's.
#include <filesystem>
#include <string>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct ScanFile {
  TriangleMesh mesh;               // triangles in the file's order, none left out; polygons are cut into fans
  std::vector<std::string> notes;  // what is missing, for the user
};

// A glTF's scene is one surface, its nodes in place, skins in the pose that is stored; at most 1 GiB and four million
// vertices. Throws InvalidInput if there is no such file or it is too large or needs an extension, CorruptData if it is
// not what its name says or is cut, std::system_error if it cannot be read. A picture that is missing is a note.
ScanFile read_scan(const std::filesystem::path& file);

}  // namespace rotunda::recon
