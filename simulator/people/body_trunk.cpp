#include "simulator/people/body_trunk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/people/blend.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

// Height, middle, half depth, half width. Breadths and depths of ISO 7250-2 (medians), scaled to 1.75 m.
struct Section {
  double z, middle, depth, width;
};
using Trunk = std::array<Section, 11>;
constexpr Trunk kMale = {{{0.84, -0.012, 0.105, 0.140},
                          {0.89, -0.012, 0.118, 0.168},
                          {0.95, -0.008, 0.114, 0.170},
                          {1.02, -0.004, 0.106, 0.158},
                          {1.10, -0.006, 0.102, 0.149},
                          {1.20, -0.012, 0.108, 0.156},
                          {1.30, -0.018, 0.116, 0.172},
                          {1.38, -0.024, 0.106, 0.176},
                          {1.43, -0.026, 0.086, 0.142},
                          {1.47, -0.026, 0.066, 0.094},
                          {1.52, -0.022, 0.056, 0.064}}};
constexpr Trunk kFemale = {{{0.84, -0.012, 0.108, 0.150},
                            {0.89, -0.014, 0.120, 0.180},
                            {0.95, -0.010, 0.116, 0.178},
                            {1.02, -0.004, 0.102, 0.158},
                            {1.10, -0.004, 0.090, 0.134},
                            {1.20, -0.012, 0.094, 0.134},
                            {1.30, -0.018, 0.100, 0.148},
                            {1.38, -0.024, 0.092, 0.152},
                            {1.43, -0.026, 0.074, 0.124},
                            {1.47, -0.026, 0.056, 0.080},
                            {1.52, -0.022, 0.047, 0.054}}};

double catmull_rom(double p0, double p1, double p2, double p3, double t) {
  return p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

Section section_at(const Trunk& trunk, double z) {
  const double inside = std::clamp(z, trunk.front().z, trunk.back().z - 1e-9);
  std::size_t i = 0;
  while (trunk[i + 1].z <= inside) ++i;
  const Section &a = trunk[i > 0 ? i - 1 : 0], &b = trunk[i], &c = trunk[i + 1];
  const Section& d = trunk[std::min(i + 2, trunk.size() - 1)];
  const double t = (inside - b.z) / (c.z - b.z);
  return {z, catmull_rom(a.middle, b.middle, c.middle, d.middle, t), catmull_rom(a.depth, b.depth, c.depth, d.depth, t),
          catmull_rom(a.width, b.width, c.width, d.width, t)};
}

double bump(double z, double middle, double half) {
  return std::exp(-std::pow((z - middle) / half, 2));
}

// Girth, waist, hips and shoulders of the build.
Section shaped(const BodyBuild& build, Section s) {
  const double waist = 1.0 + (build.waist - 1.0) * bump(s.z, 1.10, 0.12);
  const double hips = 1.0 + (build.proportions.hips - 1.0) * bump(s.z, 0.92, 0.12);
  const double chest = 1.0 + (build.proportions.shoulders - 1.0) * bump(s.z, 1.40, 0.13);
  s.width *= build.girth * waist * hips * chest;
  s.depth *= build.girth * waist;
  const double belly = build.belly * bump(s.z, 1.06, 0.11);
  s.depth += 0.5 * belly;
  s.middle += 0.5 * belly;
  return s;
}

}  // namespace

double trunk_distance(const BodyBuild& build, const Vector3d& q, double ease) {
  const Section s = shaped(build, section_at(build.sex == Sex::male ? kMale : kFemale, q.z()));
  const Eigen::Vector2d r(s.depth + ease, s.width + ease);
  const Eigen::Vector2d unit = Eigen::Vector2d(q.x() - s.middle, q.y()).cwiseQuotient(r);
  const double k0 = unit.norm(), k1 = unit.cwiseQuotient(r).norm();
  const double side = k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -r.minCoeff();
  return smooth_max(smooth_max(side, q.z() - 1.50, 0.05), 0.845 - q.z(), 0.04);
}

}  // namespace rotunda::simulator
