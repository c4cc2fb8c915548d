#include "simulator/studio/material.h"

#include <algorithm>
#include <cmath>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

float pow5(float x) {
  return x * x * x * x * x;
}

// Strands hang, or lie back where the head is level.
Vector3f strand_along(const Vector3f& normal) {
  const Vector3f down = -Vector3f::UnitZ() + normal.z() * normal;
  const Vector3f back = -Vector3f::UnitX() + normal.x() * normal;
  return (down + 0.15F * back).normalized();
}

// Kajiya and Kay (1989) with two highlights shifted to root and tip (Marschner et al. 2003): off the strands' surface,
// white; through the strands, in their own colour.
struct Strands {
  float white, coloured;
};
Strands strand_highlights(const Vector3f& along, const Vector3f& normal, const Vector3f& half) {
  const auto lobe = [&](float shift, float exponent) {
    const float t = (along + shift * normal).normalized().dot(half);
    return std::pow(std::max(0.0F, 1.0F - t * t), 0.5F * exponent);
  };
  return {0.055F * lobe(0.10F, 90.0F), 0.75F * lobe(-0.14F, 22.0F)};
}

}  // namespace

const MaterialLook& look_of(SurfaceMaterial material) {
  // Skin: 1.4 refractive index; red light goes three times as far as blue (Jensen et al. 2001).
  static const std::array<MaterialLook, 8> kLooks{{
      {{0.06F, 0.06F, 0.06F}, 0.030F, 0.80F, 0.16F},  // cloth
      {{0.30F, 0.13F, 0.08F}, 0.028F, 0.42F, 0.04F},  // skin
      {{0.18F, 0.14F, 0.12F}, 0.046F, 0.60F, 0.00F},  // hair
      {{0.12F, 0.10F, 0.10F}, 0.025F, 0.12F, 0.00F},  // eye, wet
      {{0.22F, 0.10F, 0.08F}, 0.030F, 0.30F, 0.00F},  // lip
      {{0.04F, 0.04F, 0.04F}, 0.035F, 0.70F, 0.10F},  // denim
      {{0.12F, 0.12F, 0.12F}, 0.025F, 0.90F, 0.30F},  // wool
      {{0.02F, 0.02F, 0.02F}, 0.040F, 0.38F, 0.00F},  // leather
  }};
  return kLooks[static_cast<std::size_t>(material)];
}

float surface_reflection(const MaterialLook& look, float n_h, float l_h) {
  const float a2 = look.roughness * look.roughness, d = n_h * n_h * (a2 - 1.0F) + 1.0F;
  const float fresnel = look.f0 + (1.0F - look.f0) * pow5(1.0F - l_h);  // Schlick 1994
  return a2 / (d * d) * fresnel / (4.0F * std::max(0.05F, l_h * l_h));
}

Vector3f wrapped_cosine(float facing, const Vector3f& wrap) {
  const Eigen::Array3f w = wrap.array();
  return ((facing + w).max(0.0F) / ((1.0F + w) * (1.0F + w))).matrix();
}

SeenLight seen_light(SurfaceMaterial material, const ArrivingLight& arriving, const Vector3f& position,
                     const Vector3f& normal, const Vector3f& to_eye) {
  const MaterialLook& look = look_of(material);
  const bool is_hair = material == SurfaceMaterial::hair;
  const float n_v = std::clamp(normal.dot(to_eye), 0.0F, 1.0F), grazing = pow5(1.0F - n_v);
  SeenLight seen{arriving.diffuse * (1.0F + look.sheen * std::pow(1.0F - n_v, 3.0F)), Vector3f::Zero()};
  const Vector3f along = is_hair ? strand_along(normal) : Vector3f::Zero();
  for (std::size_t i = 0; i < kLamps; ++i) {
    const Lamp& lamp = lamps()[i];
    if (arriving.lamps[i] <= 0.0F) continue;
    const Vector3f way = lamp.place - position;
    const float distance = way.norm();
    const Vector3f to_lamp = way / distance, half = (to_lamp + to_eye).normalized();
    const float facing = normal.dot(to_lamp);
    if (facing <= 0.0F) continue;
    const Vector3f light = arriving.lamps[i] * facing * lamp.colour;
    if (is_hair) {
      const auto strands = strand_highlights(along, normal, half);
      seen.gloss += strands.white * light;
      seen.light += strands.coloured * light;
    } else {
      MaterialLook wide = look;  // lamps are: Karis 2013
      wide.roughness = std::min(1.0F, look.roughness + lamp.size / (3.0F * distance));
      const float spread = look.roughness / wide.roughness;
      seen.gloss += spread * spread * surface_reflection(wide, normal.dot(half), to_lamp.dot(half)) * light;
    }
  }
  // Walls and floor, mirrored the less the rougher it is.
  const float mirrored = look.f0 + (std::max(1.0F - look.roughness, look.f0) - look.f0) * grazing + 0.2F * look.sheen;
  seen.gloss += mirrored * arriving.surroundings * arriving.glow;
  return seen;
}

}  // namespace rotunda::simulator
