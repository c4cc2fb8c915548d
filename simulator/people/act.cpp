#include "simulator/people/act.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "config/errors.h"
#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double degrees(double angle) {
  return angle * std::numbers::pi / 180.0;
}

// Stands with the arms a little off the body, breathes once in four seconds, looks about a little.
Pose idle_pose(const Skeleton& skeleton, double seconds) {
  const double phase = 2.0 * std::numbers::pi * seconds / (kActStep * 100);
  const double breath = std::sin(phase), sway = std::sin(phase + 0.8);
  Pose pose = bind_pose(skeleton);
  pose.pelvis += Vector3d(0.004 * sway, 0.006 * std::sin(phase + 2.0), -0.004 * skeleton.height);
  const auto turned = [](double angle_deg, const Vector3d& axis) {
    return Quaterniond(AngleAxisd(degrees(angle_deg), axis));
  };
  pose.rotation[index(Joint::chest)] = turned(-0.8 * breath, Vector3d::UnitY());
  pose.rotation[index(Joint::neck)] = turned(1.5 * std::sin(phase + 1.7), Vector3d::UnitZ());
  pose.rotation[index(Joint::head)] = turned(2.5 * sway, Vector3d::UnitZ());
  for (const Side side : {Side::left, Side::right}) {
    place_foot(skeleton, pose, side,
               {{0.0, sign_of(side) * 0.066 * skeleton.height, ankle_height(skeleton)}, 0.0, degrees(8.0), 0.0});
    place_arm(skeleton, pose, side, {degrees(17.0 + 0.6 * breath), degrees(1.0), degrees(14.0 + breath)});
  }
  return pose;
}

Motion walk(const Skeleton& skeleton, const MotionOptions&) {
  return {"walk", 26, true, heel_strikes(), [skeleton](double seconds) { return gait_pose(skeleton, seconds); }};
}

Motion idle(const Skeleton& skeleton, const MotionOptions&) {
  return {"idle", 100, true, {}, [skeleton](double seconds) { return idle_pose(skeleton, seconds); }};
}

Motion a_pose(const Skeleton& skeleton, const MotionOptions&) {
  return {"a-pose", 1, true, {}, [skeleton](double) { return bind_pose(skeleton); }};
}

// To add an act: a row here and the function that makes its motion.
struct ActRow {
  std::string_view name;
  Motion (*motion)(const Skeleton&, const MotionOptions&);
};
constexpr std::array<ActRow, 3> kActs = {{{"walk", walk}, {"idle", idle}, {"a-pose", a_pose}}};

}  // namespace

Motion motion_of(std::string_view act, const Skeleton& skeleton, const MotionOptions& options) {
  for (const auto& row : kActs)
    if (row.name == act) return row.motion(skeleton, options);
  throw InvalidInput(fmt::format("there is no act '{}'; the simulator knows: {}", act, fmt::join(act_names(), ", ")));
}

std::vector<std::string> act_names() {
  std::vector<std::string> names;
  for (const auto& row : kActs) names.emplace_back(row.name);
  return names;
}

}  // namespace rotunda::simulator
