#pragma once
// Union and intersection of solids given by their distances, rounded over `width` (the polynomial blend of Quilez).
#include <algorithm>
#include <cmath>

namespace rotunda::simulator {

inline double smooth_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width * 0.25;
}
inline double smooth_max(double a, double b, double width) {
  return -smooth_min(-a, -b, width);
}

}  // namespace rotunda::simulator
