#include "simulator/people/hair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/people/blend.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kNone = 1.0;  // metres: no hair near

double ellipsoid(const Vector3d& q, const Vector3d& centre, const Vector3d& radii) {
  const Vector3d u = (q - centre).cwiseQuotient(radii);
  const double k0 = u.norm(), k1 = u.cwiseQuotient(radii).norm();
  return k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -radii.minCoeff();
}

double cone(const Vector3d& q, const Vector3d& a, const Vector3d& b, double ra, double rb) {
  const double t = std::clamp((q - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (q - a - t * (b - a)).norm() - (ra + (rb - ra) * t);
}

// As body_head.cpp has it.
double skull(const Vector3d& q) {
  return smooth_min(ellipsoid(q, {-0.010, 0, 1.664}, {0.097, 0.076, 0.082}),
                    ellipsoid(q, {0.036, 0, 1.673}, {0.054, 0.061, 0.056}), 0.03);
}

struct LinePoint {
  double angle, height;
};
// Height of the hairline by the angle from straight ahead: forehead, temple, before and over the ear, nape.
constexpr std::array<LinePoint, 11> kHairline = {{{0.00, 1.7095},
                                                  {0.40, 1.7110},
                                                  {0.70, 1.7060},
                                                  {0.95, 1.6800},
                                                  {1.15, 1.6480},
                                                  {1.32, 1.6200},
                                                  {1.50, 1.6200},
                                                  {1.66, 1.6560},
                                                  {1.95, 1.6480},
                                                  {2.25, 1.6000},
                                                  {3.20, 1.5780}}};

double hairline(const Vector3d& q) {
  const double angle = std::atan2(std::abs(q.y()), q.x() - 0.004);
  std::size_t i = 0;
  while (i + 2 < kHairline.size() && kHairline[i + 1].angle < angle) ++i;
  const auto &a = kHairline[i], &b = kHairline[i + 1];
  return a.height + (b.height - a.height) * std::clamp((angle - a.angle) / (b.angle - a.angle), 0.0, 1.0);
}

double smooth_step(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// Locks: ridges that run back from the forehead and down from the crown.
double locks(const BodyBuild& build, const Vector3d& q) {
  const double round = std::atan2(q.y(), q.x() + 0.03);
  const bool is_short = build.hair == HairStyle::short_cut;
  const Vector3d along(round * (is_short ? 7.0 : 11.0), q.z() / 0.060, q.x() / 0.050);
  return solid_noise(along, build.seed + 301) + 0.5 * solid_noise(along * 2.3, build.seed + 302);
}

// Thickness of the layer on the scalp.
double layer(const BodyBuild& build, const Vector3d& q) {
  const double top = smooth_step(q.z(), 1.655, 1.725);
  double thick = 0.0;
  switch (build.hair) {
    case HairStyle::bald:
      return 0.0;
    case HairStyle::short_cut:
      thick = 0.006 + 0.013 * top;
      break;
    case HairStyle::bob:
      thick = 0.013 + 0.007 * top;
      break;
    case HairStyle::ponytail:
    case HairStyle::bun:
      thick = 0.007 + 0.004 * top;
      break;
  }
  return build.hair_volume * thick * (1.0 + (build.hair == HairStyle::short_cut ? 0.30 : 0.18) * locks(build, q));
}

// Falls to the jaw on both sides and behind, open in front.
double bob(const BodyBuild& build, const Vector3d& q) {
  const double ball = ellipsoid(q, {-0.020, 0, 1.640}, {0.098, 0.094, 0.122}) - 0.004 * build.hair_volume;
  const double front = q.x() - (0.022 + 0.22 * (q.z() - 1.60));
  const double hem = 1.540 + 0.10 * std::max(0.0, -q.x()) - q.z();
  return smooth_max(smooth_max(ball, front, 0.012), hem, 0.012) + 0.0022 * locks(build, q);
}

double ponytail(const BodyBuild& build, const Vector3d& q) {
  const Vector3d tie(-0.104, 0, 1.692), bend(-0.140, 0, 1.672), middle(-0.157, 0, 1.590), end(-0.145, 0, 1.475);
  double d = cone(q, tie, bend, 0.014, 0.022);
  d = smooth_min(d, cone(q, bend, middle, 0.022, 0.028), 0.02);
  d = smooth_min(d, cone(q, middle, end, 0.028, 0.008), 0.02);
  return d + 0.0025 * locks(build, q);
}

double bun(const BodyBuild& build, const Vector3d& q) {
  const double coil = std::sin(6.0 * std::atan2(q.y(), q.z() - 1.700) + 60.0 * (q.x() + 0.11));
  return ellipsoid(q, {-0.116, 0, 1.700}, {0.030, 0.037, 0.037}) + 0.0015 * coil + 0.001 * locks(build, q);
}

}  // namespace

// Single strands before the dense hair: across 2 mm, along 2 cm.
double hair_cover(const BodyBuild& build, const Vector3d& q) {
  if (build.hair == HairStyle::bald) return 0.0;
  const double round = 0.085 * std::atan2(q.y(), q.x() + 0.03);
  const Vector3d along(round / 0.0021, q.z() / 0.022, q.x() / 0.022);
  const double ragged = 0.009 * solid_noise(along, build.seed + 303) + 0.004 * solid_noise(q / 0.018, build.seed + 304);
  return smooth_step(q.z() - hairline(q) + ragged, 0.000, 0.010);
}

double hair_distance(const BodyBuild& build, const Vector3d& q) {
  if (build.hair == HairStyle::bald) return kNone;
  const double scalp = skull(q);
  if (scalp > 0.2) return scalp - 0.1;
  // Thickens over 5 cm from the hairline, below which it lies under the skin.
  const double beyond = q.z() - hairline(q);
  double d = scalp - (beyond > 0.0 ? layer(build, q) * smooth_step(beyond, -0.004, 0.048) : 0.35 * beyond);
  if (build.hair == HairStyle::bob) d = smooth_min(d, bob(build, q), 0.012);
  if (build.hair == HairStyle::ponytail) d = smooth_min(d, ponytail(build, q), 0.012);
  if (build.hair == HairStyle::bun) d = smooth_min(d, bun(build, q), 0.008);
  return d;
}

}  // namespace rotunda::simulator
