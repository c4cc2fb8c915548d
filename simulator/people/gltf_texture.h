#pragma once
// The colours of a glTF character as one SurfaceTexture. Private to gltf_surface.
#include "recon/gltf/gltf_character.h"
#include "simulator/people/surface_texture.h"

namespace rotunda::simulator {

// Three corners for every triangle of every part, in their order. Base colours only: what shines or glows does not.
SurfaceTexture character_texture(const recon::GltfCharacter& character);

}  // namespace rotunda::simulator
