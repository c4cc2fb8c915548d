#include "simulator/studio/light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

// Of the floor's light, the share that comes from walls and ceiling and not from a lamp.
constexpr float kFloorGlow = 0.28F;

}  // namespace

const std::array<Lamp, kLamps>& lamps() {
  static const std::array<Lamp, kLamps> kRig = {{{{2.8F, 2.2F, 3.4F}, {0.50F, 0.475F, 0.44F}, 0.35F, 1.6F},
                                                 {{2.6F, -2.6F, 3.2F}, {0.30F, 0.305F, 0.32F}, 0.45F, 2.0F},
                                                 {{-2.9F, 2.4F, 3.5F}, {0.34F, 0.335F, 0.325F}, 0.40F, 1.8F},
                                                 {{-2.7F, -2.3F, 3.4F}, {0.36F, 0.36F, 0.365F}, 0.40F, 1.8F},
                                                 {{0.2F, 0.0F, 4.6F}, {0.26F, 0.255F, 0.25F}, 0.50F, 2.4F}}};
  return kRig;
}

Vector3f irradiance(const Vector3f& position, const Vector3f& normal, float openness, const Visibility& visibility) {
  Vector3f from_lamps = Vector3f::Zero();
  for (std::size_t i = 0; i < kLamps; ++i) {
    const Lamp& lamp = lamps()[i];
    const Vector3f to_lamp = lamp.place - position;
    const float falloff = lamp.place.squaredNorm() / to_lamp.squaredNorm();
    const float facing = (normal.dot(to_lamp.normalized()) + lamp.softness) / (1.0F + lamp.softness);
    from_lamps += visibility.lamps[i] * falloff * std::max(0.0F, facing) * std::max(0.0F, facing) * lamp.colour;
  }
  const float floor_share = 0.5F - 0.5F * normal.z();
  const float low = std::exp(-std::max(0.0F, position.z()) / 0.5F);
  Vector3f around = Vector3f(0.11F, 0.115F, 0.125F) * (0.6F + 0.4F * normal.z());
  around += kWallGlow * (0.16F + 0.30F * floor_share * (0.5F + low));
  const float crease = (0.3F + 0.7F * openness) * std::sqrt(openness);
  return from_lamps * crease + around * openness * (0.25F + 0.75F * visibility.surroundings) * 1.1F;
}

float floor_light(const Vector3f& position, const Visibility& visibility) {
  float seen = 0.0F, all = 0.0F;
  for (std::size_t i = 0; i < kLamps; ++i) {
    const Vector3f to_lamp = lamps()[i].place - position;
    const float share = lamps()[i].colour.y() * to_lamp.normalized().z() / to_lamp.squaredNorm();
    seen += share * visibility.lamps[i];
    all += share;
  }
  return (1.0F - kFloorGlow) * seen / all + kFloorGlow * visibility.surroundings;
}

float grazing_reflection(const Vector3f& normal, const Vector3f& to_eye) {
  const float rest = 1.0F - std::clamp(normal.dot(to_eye), 0.0F, 1.0F);
  return 0.02F + 0.30F * rest * rest * rest * rest;
}

}  // namespace rotunda::simulator
