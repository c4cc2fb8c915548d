#pragma once
// What a surface is made of, as far as light minds: simulator/studio/material.h says how each reflects it.
#include <cstdint>

namespace rotunda::simulator {

enum class SurfaceMaterial : std::uint8_t { cloth, skin, hair, eye, lip, denim, wool, leather };

}  // namespace rotunda::simulator
