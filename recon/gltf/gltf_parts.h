#pragma once
// The two big halves of reading a glTF character: its surface and its clips. Private to gltf_character.
#include "recon/gltf/gltf_accessor.h"
#include "recon/gltf/gltf_character.h"

namespace rotunda::recon {

// The parts of all nodes that have a mesh; `order`: the file's node of each of the character's.
void read_parts(const GltfFile& file, const std::vector<std::size_t>& order, GltfAccessors& accessors,
                GltfCharacter& character);

// `place`: the character's node of each of the file's, -1 for those outside the scene.
void read_clips(const GltfFile& file, const std::vector<int>& place, GltfAccessors& accessors,
                GltfCharacter& character);

}  // namespace rotunda::recon
