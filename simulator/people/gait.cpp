#include "simulator/people/gait.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double degrees(double angle) {
  return angle * kPi / 180.0;
}

struct Key {
  double phase, value;
};

// Periodic cubic through the keys with limited slopes (Fritsch and Carlson 1980): flat between equal keys.
template <std::size_t N>
double periodic_curve(const std::array<Key, N>& keys, double phase) {
  phase -= std::floor(phase);
  std::size_t i = N - 1;
  for (std::size_t k = 0; k + 1 < N; ++k)
    if (phase >= keys[k].phase && phase < keys[k + 1].phase) i = k;
  const auto key = [&](std::size_t k) {  // keys run on into the next period
    return Key{keys[k % N].phase + static_cast<double>(k / N), keys[k % N].value};
  };
  const auto secant = [&](std::size_t k) {
    return (key(k + 1).value - key(k).value) / (key(k + 1).phase - key(k).phase);
  };
  const auto slope = [&](std::size_t k) {
    const double a = secant(k + N - 1), b = secant(k + N);
    return a * b <= 0.0 ? 0.0 : 2.0 * a * b / (a + b);
  };
  const double width = key(i + 1).phase - key(i).phase, t = (phase - key(i).phase) / width;
  const double s = 1.0 - t;
  return s * s * (1.0 + 2.0 * t) * key(i).value + t * t * (3.0 - 2.0 * t) * key(i + 1).value +
         width * t * s * (s * slope(i) - t * slope(i + 1));
}

// Degrees over the stride from heel strike, Winter (1991), natural cadence.
constexpr std::array<Key, 11> kHip = {{{0.0, 20},
                                       {0.05, 19},
                                       {0.1, 16},
                                       {0.2, 9},
                                       {0.3, 1},
                                       {0.4, -6},
                                       {0.51, -10},
                                       {0.6, -5},
                                       {0.7, 9},
                                       {0.8, 19},
                                       {0.88, 22}}};
constexpr std::array<Key, 15> kKnee = {{{0.0, 4},
                                        {0.05, 11},
                                        {0.1, 17},
                                        {0.15, 19},
                                        {0.2, 17},
                                        {0.3, 10},
                                        {0.4, 6},
                                        {0.5, 12},
                                        {0.55, 23},
                                        {0.6, 38},
                                        {0.65, 54},
                                        {0.72, 64},
                                        {0.8, 53},
                                        {0.9, 19},
                                        {0.97, 2}}};
constexpr std::array<Key, 12> kAnkle = {{{0.0, 0},
                                         {0.05, -5},
                                         {0.1, -2},
                                         {0.2, 4},
                                         {0.3, 7},
                                         {0.43, 10},
                                         {0.5, 5},
                                         {0.55, -7},
                                         {0.63, -19},
                                         {0.7, -11},
                                         {0.8, -1},
                                         {0.9, 1}}};
// The foot against the floor that these three add up to, with the sole held flat between foot flat and heel off
// (Perry 1992: 8 to 12 % and 31 to 40 %). Toes up is positive.
constexpr std::array<Key, 11> kFootPitch = {{{0.0, 17},
                                             {0.10, 0},
                                             {0.36, 0},
                                             {0.45, -9},
                                             {0.5, -18},
                                             {0.56, -38},
                                             {0.62, -60},
                                             {0.68, -70},
                                             {0.8, -35},
                                             {0.9, 4},
                                             {0.96, 17}}};

Vector2d rotated(const Vector2d& v, double pitch) {  // (x, z), toes up
  return {v.x() * std::cos(pitch) - v.y() * std::sin(pitch), v.x() * std::sin(pitch) + v.y() * std::cos(pitch)};
}

// The back of the sole in the sagittal plane: an ellipse (body_parts.cpp), from the ankle; metres at 1.75 m.
struct Heel {
  Vector2d centre;
  double a, b;
  explicit Heel(const Skeleton& skeleton) {
    const double scale = skeleton.height / 1.75;
    a = 0.036 * scale;
    b = 0.30 * a;
    centre = {-0.036 * scale, 0.012 * scale - ankle_height(skeleton)};
  }
  // The point that touches the floor at a pitch, and the length of sole from the flat part to it.
  double parameter(double pitch) const { return std::atan2(a * std::sin(pitch), b * std::cos(pitch)); }
  Vector2d contact(double pitch) const {
    const double u = parameter(pitch);
    return centre + Vector2d(-a * std::sin(u), -b * std::cos(u));
  }
  double arc(double pitch) const {
    constexpr int kSteps = 24;
    double sum = 0.0, end = parameter(pitch);
    for (int i = 0; i < kSteps; ++i) {
      const double u = end * (i + 0.5) / kSteps;
      sum += std::hypot(a * std::cos(u), b * std::sin(u)) * end / kSteps;
    }
    return sum;
  }
};

// Ankle (x, z) of a foot that stands on the floor with its flat sole's ankle at x = 0. Heel down: the sole rolls over
// its rounded back without slipping; heel up: it turns about the ball, the toes stay flat.
Vector2d standing_ankle(const Skeleton& skeleton, double pitch) {
  if (pitch >= 0.0) {
    const Heel heel(skeleton);
    const Vector2d floor_contact(heel.centre.x() - heel.arc(pitch), 0.0);
    Vector2d ankle = floor_contact - rotated(heel.contact(pitch), pitch);
    ankle.y() += ankle_height(skeleton) + heel.centre.y() - heel.b;  // as the flat sole lies in the bind pose
    return ankle;
  }
  const Vector3d toes = skeleton.joint[index(Joint::toes_left)], ankle = skeleton.joint[index(Joint::foot_left)];
  const Vector2d ball(toes.x() - ankle.x(), toes.z());
  return ball + rotated(Vector2d(ankle.x() - toes.x(), ankle.z() - toes.z()), pitch);
}

// The hips are carried lower than the curves' subjects', so the swinging foot is lifted clear of the floor, metres.
constexpr double kSwingLift = 0.028;

double bob(double phase) {
  return 0.014 * std::cos(4.0 * kPi * (phase - 0.30));
}

// Ankle (x, z) from under the hip by the normal angles alone, z from the floor; `hip_height` above the floor.
Vector2d free_ankle(const Skeleton& skeleton, double phase, double hip_height) {
  const LegAngles angles = normal_leg_angles(phase);
  const double shank = angles.hip - angles.knee, scale = std::cos(skeleton.leg_angle);
  return {skeleton.thigh_length() * std::sin(angles.hip) + skeleton.shank_length() * std::sin(shank),
          hip_height + bob(phase) -
              scale * (skeleton.thigh_length() * std::cos(angles.hip) + skeleton.shank_length() * std::cos(shank))};
}

// The path of one ankle over a stride. What the angles leave open against floor and belt is made up exactly in stance
// and runs out smoothly over the swing.
class AnklePath {
 public:
  AnklePath(const Skeleton& skeleton, const GaitOptions& options, double hip_height)
      : skeleton_(skeleton), options_(options), hip_height_(hip_height) {
    constexpr int kSamples = 50;
    double sum = 0.0;  // while start_ is 0
    for (int i = 0; i < kSamples; ++i) sum += error(kToeOff * (i + 0.5) / kSamples).x();
    start_ = -sum / kSamples;
  }

  Vector2d at(double phase) const {
    phase -= std::floor(phase);
    if (phase <= kToeOff) return stance(phase);
    const double t = (phase - kToeOff) / (1.0 - kToeOff), s = 1.0 - t;
    const Vector2d correction = s * s * (1.0 + 2.0 * t) * error(kToeOff) + t * t * (3.0 - 2.0 * t) * error(0.0) +
                                fading(phase - kToeOff) * error_slope(kToeOff, -1) -
                                fading(1.0 - phase) * error_slope(0.0, 1);
    const double lift = kSwingLift * std::sin(kPi * t) * std::sin(kPi * t);
    return free_ankle(skeleton_, phase, hip_height_) + correction + Vector2d(0.0, lift);
  }

  // How far the ankle has moved along the foot by rolling and by turning about the ball; metres.
  double along_foot(double phase) const {
    phase -= std::floor(phase);
    const double t = std::max(0.0, (phase - kToeOff) / (1.0 - kToeOff));
    const double now = phase <= kToeOff ? phase : kToeOff;
    const auto moved = [&](double at) { return standing_ankle(skeleton_, pitch(at)).x(); };
    return moved(now) + t * t * (3.0 - 2.0 * t) * (moved(0.0) - moved(now));
  }

  static double pitch(double phase) { return degrees(periodic_curve(kFootPitch, phase)); }

 private:
  Vector2d stance(double phase) const {
    const Vector2d belt(start_ - options_.speed * options_.period * phase, 0.0);
    return belt + standing_ankle(skeleton_, pitch(phase));
  }
  // Starts with slope 1, gone after 0.12 of a stride: carries the speed over from stance to swing.
  static double fading(double after) {
    const double rest = std::max(0.0, 1.0 - after / 0.12);
    return after * rest * rest;
  }
  Vector2d error(double phase) const { return stance(phase) - free_ankle(skeleton_, phase, hip_height_); }
  Vector2d error_slope(double phase, int direction) const {
    const double step = 0.002 * direction;
    return (error(phase + step) - error(phase)) / step;
  }

  const Skeleton& skeleton_;
  GaitOptions options_;
  double hip_height_;
  double start_ = 0.0;
};

void move_trunk(Pose& pose, double cycle) {
  const auto turned = [](double angle_deg, const Vector3d& axis) {
    return Quaterniond(AngleAxisd(degrees(angle_deg), axis));
  };
  const Vector3d z = Vector3d::UnitZ(), x = Vector3d::UnitX(), y = Vector3d::UnitY();
  const double forward = std::cos(cycle), list = std::sin(cycle + 0.2 * kPi);
  pose.rotation[index(Joint::pelvis)] = turned(-4.0 * forward, z) * turned(2.5 * list, x);
  pose.rotation[index(Joint::spine)] = turned(5.0 * forward, z) * turned(-1.5 * list, x) * turned(2.0, y);
  pose.rotation[index(Joint::chest)] = turned(4.0 * forward, z) * turned(-1.0 * list, x) * turned(1.0, y);
  pose.rotation[index(Joint::neck)] = turned(-3.0 * forward, z) * turned(-1.0, y);
  pose.rotation[index(Joint::head)] = turned(-2.0 * forward, z) * turned(-2.0, y);
}

}  // namespace

LegAngles normal_leg_angles(double phase) {
  return {degrees(periodic_curve(kHip, phase)), degrees(periodic_curve(kKnee, phase)),
          degrees(periodic_curve(kAnkle, phase))};
}

Pose gait_pose(const Skeleton& skeleton, double seconds, const GaitOptions& options) {
  const double stride = seconds / options.period - std::floor(seconds / options.period);
  const double cycle = 2.0 * kPi * stride, scale = skeleton.height / 1.75;
  Pose pose = bind_pose(skeleton);
  const double drop = 0.020 * scale;  // the hips of a walker against those of one who stands straight
  pose.pelvis += Vector3d(0.0, 0.014 * std::sin(cycle - 0.1 * kPi), bob(stride) - drop);
  move_trunk(pose, cycle);
  const AnklePath path(skeleton, options, skeleton.joint[index(Joint::thigh_left)].z() - drop);
  for (const Side side : {Side::left, Side::right}) {
    const double s = sign_of(side), phase = side == Side::left ? stride : stride + 0.5;
    const Vector2d ankle = path.at(phase);
    const double pitch = AnklePath::pitch(phase), own = phase - std::floor(phase);
    const double release = std::clamp((own - kToeOff - 0.05) / 0.14, 0.0, 1.0);  // the toes straighten after toe-off
    const double toe_out = degrees(5.0), y = s * (0.088 * scale + std::sin(toe_out) * path.along_foot(phase));
    place_foot(skeleton, pose, side,
               {{ankle.x(), y, ankle.y()}, pitch, toe_out, std::max(0.0, -pitch) * (1.0 - release)});
    const double swing = -s * std::cos(cycle);  // forwards with the other leg
    place_arm(skeleton, pose, side, {degrees(15.0), degrees(2.0 + 19.0 * swing), degrees(24.0 + 10.0 * swing)});
  }
  return pose;
}

std::vector<HeelStrike> heel_strikes(const GaitOptions& options) {
  return {{0.0, Side::left}, {0.5 * options.period, Side::right}};
}

}  // namespace rotunda::simulator
