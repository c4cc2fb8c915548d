#pragma once
// Strokes of paint on a solid texture: colours are sRGB in 0 to 1, lengths metres.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::simulator::paint {

inline Eigen::Vector3d rgb(const recon::Colour& colour) {
  return Eigen::Vector3d(colour[0], colour[1], colour[2]) / 255.0;
}
inline Eigen::Vector3d mix(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) {
  return a + (b - a) * std::clamp(t, 0.0, 1.0);
}
// 1 within `half` of zero, falling to 0 over `soft`.
inline double band(double x, double half, double soft) {
  return std::clamp((half + soft - std::abs(x)) / soft, 0.0, 1.0);
}
inline double step_up(double x, double soft) {
  return std::clamp(x / soft * 0.5 + 0.5, 0.0, 1.0);
}
// Distance from the nearest multiple of `period`.
inline double from_line(double x, double period) {
  return x - period * std::round(x / period);
}
inline double disc(double dx, double dy, double radius, double soft) {
  return band(std::hypot(dx, dy), radius, soft);
}

}  // namespace rotunda::simulator::paint
