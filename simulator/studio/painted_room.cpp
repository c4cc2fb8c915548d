#include "simulator/studio/painted_room.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "simulator/people/solid_noise.h"
#include "simulator/studio/light.h"
#include "simulator/studio/material.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kTurn = 2.0 * std::numbers::pi;
// Linear reflectances of chroma-key paints, and of tape in nearly the paint's colour.
struct Colours {
  Vector3d paint, tape;
};
const Colours kBlueScreen{{0.030, 0.105, 0.480}, {0.052, 0.140, 0.430}};
const Colours kGreenScreen{{0.055, 0.420, 0.090}, {0.080, 0.375, 0.125}};

const Colours& colours_of(ScreenPaint paint) {
  return paint == ScreenPaint::blue ? kBlueScreen : kGreenScreen;
}

constexpr double kLevel = 0.95;   // mean light on floor and wall
constexpr double kCove = 0.6;     // metres of floor and of wall that bend into each other
constexpr int kFloods = 9;        // lamps that wash the wall
constexpr double kWalked = 3.2;   // metres about the middle in which people scuff the floor
constexpr int kWalkedCells = 16;  // along each side
constexpr int kScuffs = 90;
constexpr double kPanel = 1.25, kSheet = 2.0;  // metres: widths of the wall's boards and of the floor's vinyl
constexpr float kLampGlow = 7.0F;              // of a soft box looked into
constexpr double kFloorGloss = 0.42;           // GGX alpha of emulsion paint

// Share of a pixel that a line of this half width covers at a distance from it.
double line(double distance, double half, double footprint) {
  const double soft = std::max(footprint, 1e-4);
  const double cover = std::clamp((half + 0.5 * soft - std::abs(distance)) / soft, 0.0, 1.0);
  return cover * std::min(1.0, 2.0 * half / soft);
}

// Structure of this size, as far as pixels tell it.
double told(double size, double footprint) {
  return std::clamp(1.5 - footprint / size, 0.0, 1.0);
}

double from_multiple(double x, double period) {
  return x - period * std::round(x / period);
}

double segment_distance(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double t = std::clamp((p - a).dot(along) / std::max(1e-9, along.squaredNorm()), 0.0, 1.0);
  return (p - a - t * along).norm();
}

int walked_cell(double x) {
  return static_cast<int>(std::floor((x + kWalked) / (2.0 * kWalked) * kWalkedCells));
}

// Ceiling, curtains and cables in what little light comes back to them.
Vector3f dark_studio(const Vector3d& ray, std::uint32_t seed) {
  const double fold = 0.6 + 0.4 * solid_noise(Vector3d(std::atan2(ray.y(), ray.x()) * 14.0, ray.z() * 2.0, 0.0), seed);
  return (0.006 * fold * Vector3d(0.9, 1.0, 1.5)).cast<float>();
}

}  // namespace

PaintedRoom::PaintedRoom(const BackdropOptions& options) : options_(options) {
  trim_lamps();
  if (options_.wear > 0.0) scuff_floor();
}

double PaintedRoom::lamp_light(const Spot& spot) const {
  double light = 0.16;  // from all around
  for (const auto& lamp : lamps()) {
    const Vector3d way = lamp.place.cast<double>() - spot.point;
    const Vector3d facing = (lamp.place.cast<double>() - Vector3d::UnitZ()).normalized();
    const double distance = way.norm(), reference = static_cast<double>(lamp.place.squaredNorm());
    const double beam = std::max(0.0, facing.dot(way) / distance);  // soft boxes shine forwards
    light += static_cast<double>(lamp.colour.y()) * beam * reference / (distance * distance) *
             std::max(0.0, spot.normal.dot(way) / distance);
  }
  for (int i = 0; i < kFloods; ++i) {
    const double azimuth = kTurn * (i + 0.6 * hashed_unit(i, 0, 0, options_.seed + 31)) / kFloods;
    const double power = 1.7 * (0.75 + 0.5 * hashed_unit(i, 1, 0, options_.seed + 31));
    const double out = options_.wall_radius - 1.6;
    const Vector3d place(out * std::cos(azimuth), out * std::sin(azimuth), options_.wall_height + 0.3);
    const Vector3d way = place - spot.point;
    const double squared = way.squaredNorm() + 0.5;
    light += power * std::max(0.0, spot.normal.dot(way)) / (squared * std::sqrt(squared)) * 2.0;
  }
  return light;
}

// Lamps are dimmed and turned until brightest and darkest are as asked: a power keeps their pattern.
void PaintedRoom::trim_lamps() {
  std::vector<double> light;
  for (int i = 0; i < 36; ++i) {
    const Vector3d out(std::cos(kTurn * i / 36), std::sin(kTurn * i / 36), 0.0);
    for (int j = 0; j < 12; ++j) {
      light.push_back(lamp_light({(j + 0.5) / 12.0 * options_.wall_radius * out, Vector3d::UnitZ(), 0.0, true}));
      const double z = (j + 0.5) / 12.0 * std::min(3.0, options_.wall_height);
      light.push_back(lamp_light({options_.wall_radius * out + z * Vector3d::UnitZ(), -out, 0.0, false}));
    }
  }
  std::sort(light.begin(), light.end());
  const auto at = [&](double share) {
    return light[static_cast<std::size_t>(share * static_cast<double>(light.size()))];
  };
  mean_light_ = at(0.5);
  trim_ = std::log(std::max(1.0, options_.unevenness)) / std::log(at(0.98) / at(0.02));
}

void PaintedRoom::scuff_floor() {
  scuffs_near_.resize(kWalkedCells * kWalkedCells);
  const int count = static_cast<int>(kScuffs * std::min(4.0, options_.wear));
  for (int i = 0; i < count; ++i) {
    const auto random = [&](std::int64_t what) { return hashed_unit(i, what, 5, options_.seed + 40); };
    const double radius = 0.9 * kWalked * std::sqrt(random(0)), azimuth = kTurn * random(1), turn = kTurn * random(2);
    const double length = 0.03 + 0.22 * random(3) * random(3);
    const Vector2d from(radius * std::cos(azimuth), radius * std::sin(azimuth));
    scuffs_.push_back({from, from + length * Vector2d(std::cos(turn), std::sin(turn)), 0.002 + 0.006 * random(4),
                       0.08 + 0.30 * random(5) * random(5)});
    const Scuff& scuff = scuffs_.back();
    const double reach = scuff.width + 0.02;
    for (int x = walked_cell(std::min(scuff.from.x(), scuff.to.x()) - reach);
         x <= walked_cell(std::max(scuff.from.x(), scuff.to.x()) + reach); ++x)
      for (int y = walked_cell(std::min(scuff.from.y(), scuff.to.y()) - reach);
           y <= walked_cell(std::max(scuff.from.y(), scuff.to.y()) + reach); ++y)
        if (x >= 0 && y >= 0 && x < kWalkedCells && y < kWalkedCells)
          scuffs_near_[static_cast<std::size_t>(y * kWalkedCells + x)].push_back(scuffs_.size() - 1);
  }
}

// Vinyl sheets, their joints under tape, marks for the performer, scuffs and the dust of shoes.
Vector3d PaintedRoom::floor_paint(const Spot& spot) const {
  const auto& colours = colours_of(options_.paint);
  const Vector3d& p = spot.point;
  const double wear = options_.wear, fine = spot.footprint;
  const std::uint32_t seed = options_.seed;
  const double blotch = 0.022 * fractal_noise(p / 0.7, 3, seed);
  const double roller = told(0.10, fine) * 0.010 * solid_noise(Vector3d(p.x() / 0.22, p.y() / 0.9, 0.0), seed + 9) +
                        told(0.02, fine) * 0.012 * solid_noise(p / 0.02, seed + 10);
  Vector3d paint = colours.paint * (1.0 + wear * (blotch + roller));
  const double sheet = std::floor(p.x() / kSheet + 0.5);
  paint *= 1.0 + wear * 0.020 * (hashed_unit(static_cast<std::int64_t>(sheet), 3, 0, seed) - 0.5);
  const double joint = from_multiple(p.x() - 0.5 * kSheet, kSheet);
  const double frayed = 0.001 * solid_noise(Vector3d(0.0, p.y() / 0.03, 0.0), seed + 11);
  paint += std::min(1.0, wear) * 0.35 * line(joint, 0.024 + frayed, fine) * (colours.tape - paint);
  paint *= 1.0 - wear * 0.10 * (line(joint - 0.024, 0.0015, fine) + line(joint + 0.024, 0.0015, fine));
  const double mark = std::max(line(p.x(), 0.012, fine) * line(p.y(), 0.09, fine),  // where the performer begins
                               line(p.y(), 0.012, fine) * line(p.x() - 0.03, 0.06, fine));
  paint += std::min(1.0, wear) * 0.7 * mark * (colours.tape - paint);
  const double dust = std::exp(-p.head<2>().squaredNorm() / 2.2) * std::max(0.0, fractal_noise(p / 0.21, 3, seed + 20));
  paint += wear * dust * Vector3d(0.012, 0.012, 0.006);
  const int column = walked_cell(p.x()), row = walked_cell(p.y());
  if (scuffs_near_.empty() || column < 0 || row < 0 || column >= kWalkedCells || row >= kWalkedCells) return paint;
  for (const auto number : scuffs_near_[static_cast<std::size_t>(row * kWalkedCells + column)]) {
    const Scuff& scuff = scuffs_[number];
    const double cover = scuff.strength * line(segment_distance(p.head<2>(), scuff.from, scuff.to), scuff.width, fine);
    paint += cover * (Vector3d(0.030, 0.042, 0.075) - paint);
  }
  return paint;
}

// Boards, joints filled and painted over, strokes of the roller that lap.
Vector3d PaintedRoom::wall_paint(const Spot& spot) const {
  const auto& colours = colours_of(options_.paint);
  const Vector3d& p = spot.point;
  const double wear = options_.wear, fine = spot.footprint, round = options_.wall_radius * std::atan2(p.y(), p.x());
  const std::uint32_t seed = options_.seed;
  const auto tint = [&](double cell, std::uint32_t channel) {
    return hashed_unit(static_cast<std::int64_t>(cell), channel, 1, seed) - 0.5;
  };
  const double waver = 0.15 * solid_noise(Vector3d(round / 0.4, 0.0, p.z() / 0.8), seed + 12);
  const double lap = told(0.10, fine) * 0.016 * tint(std::floor(round / 0.23 + waver), 1);
  const double nap = told(0.03, fine) * 0.010 * solid_noise(Vector3d(round / 0.03, 0.0, p.z() / 0.05), seed + 13);
  const double blotch = 0.016 * fractal_noise(p / 0.9, 3, seed + 2);
  Vector3d paint = colours.paint * (1.0 + wear * (lap + nap + blotch + 0.022 * tint(std::floor(round / kPanel), 2)));
  const double joint = from_multiple(round, kPanel), across = p.z() - 2.44;
  const double filled = std::exp(-std::pow(joint / 0.05, 2)) + std::exp(-std::pow(across / 0.05, 2));
  paint *= 1.0 + wear * 0.014 * filled;
  paint *= 1.0 - wear * 0.13 * std::min(1.0, line(joint, 0.0015, fine) + line(across, 0.0015, fine));
  const double kicked =
      std::exp(-std::pow((p.z() - 0.25) / 0.2, 2)) * std::max(0.0, fractal_noise(p / 0.12, 2, seed + 21));
  return paint + wear * 0.010 * kicked * Vector3d::Ones();
}

// The paint's skin mirrors the soft boxes, dimly and wide.
Vector3f PaintedRoom::shine(const Spot& spot, const Vector3d& to_eye) const {
  Vector3f sum = Vector3f::Zero();
  const MaterialLook paint{Vector3f::Zero(), 0.028F, static_cast<float>(kFloorGloss), 0.0F};
  for (const auto& lamp : lamps()) {
    const Vector3d way = lamp.place.cast<double>() - spot.point;
    const double distance = way.norm();
    const Vector3d to_lamp = way / distance, half = (to_lamp + to_eye).normalized();
    const double facing = spot.normal.dot(to_lamp);
    if (facing <= 0.0) continue;
    const double falloff = static_cast<double>(lamp.place.squaredNorm()) / (distance * distance);
    const auto share =
        surface_reflection(paint, static_cast<float>(spot.normal.dot(half)), static_cast<float>(to_lamp.dot(half)));
    sum += static_cast<float>(options_.gloss * facing * falloff) * share * lamp.colour;
  }
  return sum;
}

Vector3f PaintedRoom::painted(const Spot& spot, const Vector3d& to_eye) const {
  const double light = kLevel * std::pow(lamp_light(spot) / mean_light_, trim_);
  const Vector3d paint = spot.is_floor ? floor_paint(spot) : wall_paint(spot);
  return (light * paint).cast<float>() + shine(spot, to_eye);
}

PaintedRoom::Seen PaintedRoom::seen_along(const Vector3d& eye, const Vector3d& ray, double pixel_angle) const {
  // The cylinder seen from inside: the far intersection.
  const double a = std::max(1e-12, ray.head<2>().squaredNorm()), b = eye.head<2>().dot(ray.head<2>());
  const double c = eye.head<2>().squaredNorm() - options_.wall_radius * options_.wall_radius;
  double distance = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
  const bool is_floor = ray.z() < 0.0 && -eye.z() / ray.z() < distance;
  if (is_floor) distance = -eye.z() / ray.z();
  Seen seen{Vector3f::Zero(), is_floor, eye + distance * ray};
  for (const auto& lamp : lamps())
    if (const auto hit = hit_lamp(lamp, eye, ray); hit && hit->distance < distance) {
      seen.is_floor = false;
      seen.linear = hit->from_front ? Vector3f(kLampGlow * lamp.colour) : Vector3f(Vector3f::Constant(0.01F));
      return seen;
    }
  if (!is_floor && seen.point.z() > options_.wall_height) {
    seen.linear = dark_studio(ray, options_.seed + 50);
    return seen;
  }
  const Vector3d inwards = -Vector3d(seen.point.x(), seen.point.y(), 0.0).normalized();
  const double from_corner =
      is_floor ? options_.wall_radius - seen.point.head<2>().norm() : -seen.point.z();  // metres, floor positive
  const double bend = std::clamp(0.5 - 0.5 * from_corner / kCove, 0.0, 1.0) * 0.5 * std::numbers::pi;
  const Vector3d normal = std::cos(bend) * Vector3d::UnitZ() + std::sin(bend) * inwards;
  const double slant = std::max(0.08, std::abs(normal.dot(ray)));
  seen.linear = painted({seen.point, normal, distance * pixel_angle / std::sqrt(slant), is_floor}, -ray);
  return seen;
}

}  // namespace rotunda::simulator
