#pragma once
// The parts of a glTF character as one Figure: vertices that only their texture coordinates set apart become one, what
// is not a manifold (more than two triangles at an edge, or fans that touch in a vertex) is cut apart there, pictures
// and colours go into one texture. The surface need not be closed.
#include "recon/gltf/gltf_character.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

struct CharacterSurface {
  Figure figure;                      // positions as `at_rest`; normals are still to be computed
  std::vector<std::uint32_t> source;  // of each vertex: its place among the vertices of all parts, one after another
};
// `at_rest`: of all parts, one after another.
CharacterSurface assemble_surface(const recon::GltfCharacter& character, const std::vector<Eigen::Vector3f>& at_rest);

}  // namespace rotunda::simulator
