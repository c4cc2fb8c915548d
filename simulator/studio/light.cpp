#include "simulator/studio/light.h"

#include <Eigen/Geometry>
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
  static const std::array<Lamp, kLamps> kRig = {{{{3.3F, 2.6F, 4.1F}, {0.62F, 0.59F, 0.545F}, 1.6F},
                                                 {{3.0F, -3.0F, 4.0F}, {0.36F, 0.365F, 0.385F}, 2.0F},
                                                 {{-3.3F, 2.7F, 4.1F}, {0.42F, 0.415F, 0.40F}, 1.8F},
                                                 {{-3.1F, -2.6F, 4.1F}, {0.45F, 0.45F, 0.455F}, 1.8F},
                                                 {{0.2F, 0.0F, 4.9F}, {0.30F, 0.295F, 0.29F}, 2.4F}}};
  return kRig;
}

std::optional<LampHit> hit_lamp(const Lamp& lamp, const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
  using Eigen::Vector3d;
  const Vector3d place = lamp.place.cast<double>();
  const Vector3d facing = (Vector3d(0.0, 0.0, 1.0) - place).normalized();
  const double slope = facing.dot(ray);
  if (std::abs(slope) < 1e-6) return std::nullopt;
  const double distance = facing.dot(place - eye) / slope;
  if (distance <= 0.0) return std::nullopt;
  const Vector3d off = eye + distance * ray - place;
  const Vector3d any = std::abs(facing.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d right = any.cross(facing).normalized(), up = facing.cross(right);
  const double half = 0.5 * static_cast<double>(lamp.size);
  if (std::abs(off.dot(right)) > half || std::abs(off.dot(up)) > half) return std::nullopt;
  return LampHit{distance, slope < 0.0};
}

ArrivingLight arriving_light(const LitPoint& point, SurfaceMaterial material, const Visibility& visibility,
                             const Vector3f& glow) {
  const Vector3f& normal = point.normal;
  const float crease = (0.3F + 0.7F * point.openness) * std::sqrt(point.openness);
  ArrivingLight arriving;
  for (std::size_t i = 0; i < kLamps; ++i) {
    const Lamp& lamp = lamps()[i];
    const Vector3f to_lamp = lamp.place - point.position;
    const float distance = to_lamp.norm();
    arriving.lamps[i] = crease * visibility.lamps[i] * lamp.place.squaredNorm() / (distance * distance);
    const Vector3f wrap = look_of(material).wrap + Vector3f::Constant(0.5F * lamp.size / distance);
    arriving.diffuse +=
        arriving.lamps[i] * wrapped_cosine(normal.dot(to_lamp) / distance, wrap).cwiseProduct(lamp.colour);
  }
  const float floor_share = 0.5F - 0.5F * normal.z();
  const float low = std::exp(-std::max(0.0F, point.position.z()) / 0.5F);
  Vector3f around = Vector3f(0.11F, 0.115F, 0.125F) * (0.6F + 0.4F * normal.z());
  around += glow * (0.16F + 0.30F * floor_share * (0.5F + low));
  arriving.glow = glow;
  arriving.surroundings = point.openness * (0.25F + 0.75F * visibility.surroundings);
  arriving.diffuse += 1.1F * arriving.surroundings * around;
  return arriving;
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

}  // namespace rotunda::simulator
