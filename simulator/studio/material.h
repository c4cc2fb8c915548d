#pragma once
// How surfaces answer to light: how far it wraps round into what is turned away (scattering below skin and in nap),
// what they reflect at their very surface, and how that depends on the eye. World frame; linear light, in which a white
// surface that faces light of 1 is seen as 1.
#include <Eigen/Core>
#include <array>

#include "simulator/people/surface_material.h"
#include "simulator/studio/shadow.h"

namespace rotunda::simulator {

struct MaterialLook {
  Eigen::Vector3f wrap;  // red, green, blue: cosine beyond the terminator that light still reaches
  float f0;              // reflectance of the surface itself at right angles
  float roughness;       // alpha of GGX (Walter et al. 2007)
  float sheen;           // of standing fibres: what they add at grazing angles, of the diffuse light
};
const MaterialLook& look_of(SurfaceMaterial material);

// Share of a lamp's light that a surface under the cosine `facing` takes up: Lambert's cosine law wrapped and scaled to
// the same whole (Green, GPU Gems, 2004). Both wraps add: the lamp's own extent lights past the horizon too.
Eigen::Vector3f wrapped_cosine(float facing, const Eigen::Vector3f& wrap);

// What the surface itself throws to the eye of light that falls on it, by GGX with the approximate shadowing of Kelemen
// and Szirmay-Kalos (2001): of the light that white would show. Cosines: of the normal and of the light to the half
// way.
float surface_reflection(const MaterialLook& look, float n_h, float l_h);

// The light on a surface point, whoever looks.
struct ArrivingLight {
  Eigen::Vector3f diffuse = Eigen::Vector3f::Zero();  // taken up, white would throw it all back
  std::array<float, kLamps> lamps{};                  // of each lamp's light, what reaches the point, before its cosine
  float surroundings = 1.0F;                          // of walls and floor
  Eigen::Vector3f glow = Eigen::Vector3f::Zero();     // what these throw back
};

// What an eye in the direction `to_eye` sees: texture * light + gloss.
struct SeenLight {
  Eigen::Vector3f light = Eigen::Vector3f::Zero(), gloss = Eigen::Vector3f::Zero();
};
SeenLight seen_light(SurfaceMaterial material, const ArrivingLight& arriving, const Eigen::Vector3f& position,
                     const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye);

}  // namespace rotunda::simulator
