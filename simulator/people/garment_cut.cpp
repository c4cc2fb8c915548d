#include "simulator/people/garment_cut.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

const Vector3d kShoulder(-0.014, 0.180, 1.419);

// The edge of the bell's ellipse at an angle, with its pleats: they are shallow at the waist and uneven round the hem.
double pleat(const Bell& bell, std::uint32_t seed, double angle, double down) {
  const double n = bell.pleats, turn = 0.7 * std::sin(2.0 * angle + 0.1 * seed) + 0.5 * std::sin(3.0 * angle + 1.9);
  const double wave = 0.62 * std::cos(n * angle + turn) + 0.38 * std::cos((n + 3.0) * angle - 1.3 * turn + 0.6 * down);
  return bell.pleat_height * wave * std::pow(down, 1.3);
}

// To add an outfit: a row here and in the enumeration.
constexpr std::array<Cut, 4> kCuts = {{
    {{Garment::shirt, 0.905, 0.030, 0.36, 0.072, 1.435, 0.004, 0.012, 0.020, 0.008, 0.0, 0.0},
     std::nullopt,
     0.003,
     0.058},
    {{Garment::tee, 0.925, 0.0, 0.185, 0.076, 1.425, 0.003, 0.005, 0.007, 0.008, 0.0, 0.0}, std::nullopt, 0.013, 0.044},
    {{Garment::bodice, 1.030, 0.0, 0.045, 0.105, 1.350, 0.002, 0.002, 0.004, 0.003, 0.0, 0.0},
     Bell{1.085, 0.560, 0.095, 0.125, 0.245, 0.275, 11, 0.020, 0.13, 0.0},
     0.0,
     0.0},
    {{Garment::coat, 0.900, 0.0, 0.555, 0.074, 1.275, 0.012, 0.015, 0.020, 0.014, 0.0, 0.0},
     Bell{1.150, 0.600, 0.120, 0.150, 0.195, 0.262, 6, 0.012, 0.10, 0.0},
     0.004,
     0.058},
}};

}  // namespace

double ramp(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

ArmPlace arm_place(const Vector3d& q) {
  const double out = std::abs(q.y()) - kShoulder.y(), down = kShoulder.z() - q.z();
  constexpr double kTan = 0.41421356;  // of half the angle between the arm and the trunk
  return {(out - kTan * down) / std::hypot(1.0, kTan), (out + down) / std::numbers::sqrt2};
}

Eigen::Vector2d cloth_coordinates(const Vector3d& q, const ArmPlace& arm) {
  if (arm.beyond > 0.0) {
    const double up = (q.z() - kShoulder.z() + std::abs(q.y()) - kShoulder.y()) / std::numbers::sqrt2;
    return {arm.along, 0.055 * std::atan2(q.x() - kShoulder.x(), up)};
  }
  constexpr double kSeam = -0.015, kFlat = 0.060;  // x of the side seam; how far from it a panel lies flat
  const double from_seam = std::abs(q.x() - kSeam);
  const double across = std::abs(q.y()) + 0.75 * std::max(0.0, kFlat - from_seam);
  const double over = ramp(q.z(), 1.36, 1.46) * 0.8 * std::max(0.0, 0.075 - from_seam);
  return {-q.z() - over, std::copysign(across, q.y())};
}

BellPlace bell_place(const Bell& bell, double girth, std::uint32_t seed, const Vector3d& q) {
  BellPlace place{};
  place.down = std::clamp((bell.top - q.z()) / (bell.top - bell.hem), 0.0, 1.0);
  const double widen = std::pow(place.down, 0.85);
  const double depth = girth * (bell.depth_top + (bell.depth_hem - bell.depth_top) * widen);
  const double width = girth * (bell.width_top + (bell.width_hem - bell.width_top) * widen);
  const double x = q.x() + 0.010, y = q.y();
  const double k0 = std::hypot(x / depth, y / width);
  const double k1 = std::hypot(x / (depth * depth), y / (width * width));
  const double fold = pleat(bell, seed, std::atan2(y, x), place.down);
  const double side = k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 - fold : -depth;
  const double reach = k1 > 1e-9 ? k0 / k1 : depth;  // about the ellipse's radius over the slope
  place.radius = (side + reach) / reach;
  constexpr double kCosine = 0.93;  // of the bell's slope
  place.outside = kCosine * side;
  const double inner = std::min(1.0, place.radius / 0.88);  // flat next to the hem: a sharper edge would have teeth
  place.underside = 0.75 * (bell.hem + bell.hollow * (1.0 - inner * inner) - q.z());
  return place;
}

constexpr double kNape = 1.38;  // the lowest a neckline goes behind

double round_neck(const Top& top, const Vector3d& q) {
  const double circle = top.neckline - std::hypot(q.x() + 0.022 - 0.15 * (q.z() - 1.47), q.y());
  return std::min(circle, q.z() - kNape);  // the neck leans: its axis would leave the body through the back
}

double neckline(const Top& top, const Vector3d& q) {
  const double v = q.x() > 0.0 ? 0.7 * (q.z() - top.neckline_dip - 1.7 * std::abs(q.y())) : -1.0;
  return std::max({round_neck(top, q), v, q.z() - kThroat});
}

const Cut& cut_of(Outfit outfit) {
  return kCuts[static_cast<std::size_t>(outfit)];
}

}  // namespace rotunda::simulator
