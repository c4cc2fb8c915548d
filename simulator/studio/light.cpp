#include "simulator/studio/light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

struct Lamp {
  Vector3f place;   // metres, world
  Vector3f colour;  // irradiance of a surface that faces it from the middle of the stage
  float softness;   // how far past the horizon a surface is still lit: a large lamp's
};

const std::array<Lamp, 5>& lamps() {
  static const std::array<Lamp, 5> kLamps = {{{{2.8F, 2.2F, 3.4F}, {0.50F, 0.475F, 0.44F}, 0.35F},
                                              {{2.6F, -2.6F, 3.2F}, {0.30F, 0.305F, 0.32F}, 0.45F},
                                              {{-2.9F, 2.4F, 3.5F}, {0.34F, 0.335F, 0.325F}, 0.40F},
                                              {{-2.7F, -2.3F, 3.4F}, {0.36F, 0.36F, 0.365F}, 0.40F},
                                              {{0.2F, 0.0F, 4.6F}, {0.26F, 0.255F, 0.25F}, 0.50F}}};
  return kLamps;
}

}  // namespace

Vector3f irradiance(const Vector3f& position, const Vector3f& normal, float openness) {
  Vector3f sum = Vector3f(0.11F, 0.115F, 0.125F) * (0.6F + 0.4F * normal.z());
  for (const auto& lamp : lamps()) {
    const Vector3f to_lamp = lamp.place - position;
    const float falloff = lamp.place.squaredNorm() / to_lamp.squaredNorm();
    const float facing = (normal.dot(to_lamp.normalized()) + lamp.softness) / (1.0F + lamp.softness);
    sum += lamp.colour * falloff * std::max(0.0F, facing) * std::max(0.0F, facing);
  }
  const float floor_share = 0.5F - 0.5F * normal.z();
  const float low = std::exp(-std::max(0.0F, position.z()) / 0.5F);
  sum += kWallGlow * (0.16F + 0.30F * floor_share * (0.5F + low));
  return sum * (0.25F + 0.75F * openness) * openness;
}

float grazing_reflection(const Vector3f& normal, const Vector3f& to_eye) {
  const float rest = 1.0F - std::clamp(normal.dot(to_eye), 0.0F, 1.0F);
  return 0.02F + 0.30F * rest * rest * rest * rest;
}

}  // namespace rotunda::simulator
