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

// To add an act: a row here and a case in pose_at.
struct ActRow {
  Act act;
  std::string_view name;
  int frames;
};
constexpr std::array<ActRow, 3> kActs = {
    {{Act::walk, "walk", 26}, {Act::idle, "idle", 100}, {Act::a_pose, "a-pose", 1}}};

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

const ActRow& row_of(Act act) {
  return kActs[static_cast<std::size_t>(act)];
}

}  // namespace

Act act_from(std::string_view name) {
  for (const auto& row : kActs)
    if (row.name == name) return row.act;
  throw InvalidInput(fmt::format("there is no act '{}'; the simulator knows: {}", name, fmt::join(act_names(), ", ")));
}

std::vector<std::string> act_names() {
  std::vector<std::string> names;
  for (const auto& row : kActs) names.emplace_back(row.name);
  return names;
}

int act_frames(Act act) {
  return row_of(act).frames;
}

std::vector<HeelStrike> heel_strikes(Act act) {
  return act == Act::walk ? heel_strikes(GaitOptions{}) : std::vector<HeelStrike>{};
}

Pose pose_at(const Skeleton& skeleton, Act act, double seconds) {
  switch (act) {
    case Act::walk:
      return gait_pose(skeleton, seconds);
    case Act::idle:
      return idle_pose(skeleton, seconds);
    case Act::a_pose:
      break;
  }
  return bind_pose(skeleton);
}

}  // namespace rotunda::simulator
