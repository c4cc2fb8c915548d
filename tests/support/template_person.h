#pragma once
// A scan of which all is known, since it is the body template itself, and a motion as somebody else's file has it.
#include <numbers>
#include <string>

#include "recon/body/body_template.h"
#include "recon/body/pose.h"

namespace rotunda::tests {

inline constexpr double kDegree = std::numbers::pi / 180.0;

// Somebody of unusual build in an A-pose: the template itself, so that all is known of them.
struct Someone {
  recon::BodyTemplate body;
  recon::Pose pose = recon::rest_pose();
};
inline Someone someone() {
  auto measures = recon::measures_of_height(1.66);
  measures[static_cast<std::size_t>(recon::BodyMeasure::thigh)] *= 1.05;
  measures[static_cast<std::size_t>(recon::BodyMeasure::upper_arm)] *= 0.95;
  measures[static_cast<std::size_t>(recon::BodyMeasure::waist_breadth)] *= 1.2;
  Someone one{recon::make_template(measures)};
  const auto turn = [&](recon::BodyJoint joint, double degrees) {
    one.pose.rotation[recon::index(joint)] = Eigen::AngleAxisd(-degrees * kDegree, Eigen::Vector3d::UnitX());
    one.pose.rotation[recon::index(recon::mirrored(joint))] =
        Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitX());
  };
  turn(recon::BodyJoint::upper_arm_left, 42);
  turn(recon::BodyJoint::thigh_left, -7);
  turn(recon::BodyJoint::foot_left, 7);
  one.pose.root.z() = recon::height_of(measures) - 0.5 * recon::height_of(measures);
  return one;
}

inline recon::TriangleMesh scan_of(const Someone& one) {
  return recon::pose_template(one.body, one.pose);
}

// As somebody else's file has it: centimetres, y up, the T-pose for zero, three frames: standing, an elbow bent at a
// right angle, a step to the side.
inline constexpr std::string_view kBvh =
    "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    "JOINT Chest\n{\nOFFSET 0 30 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT Head\n{\nOFFSET 0 25 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 20 0\n}\n}\n"
    "JOINT LeftUpperArm\n{\nOFFSET 18 18 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT LeftForearm\n{\nOFFSET 30 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT LeftHand\n{\nOFFSET 26 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 18 0 "
    "0\n}\n}\n}\n}\n"
    "JOINT RightUpperArm\n{\nOFFSET -18 18 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT RightForearm\n{\nOFFSET -30 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT RightHand\n{\nOFFSET -26 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET -18 0 "
    "0\n}\n}\n}\n}\n"
    "}\n"
    "JOINT LeftThigh\n{\nOFFSET 9 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT LeftShank\n{\nOFFSET 0 -42 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT LeftFoot\n{\nOFFSET 0 -40 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 -6 "
    "15\n}\n}\n}\n}\n"
    "JOINT RightThigh\n{\nOFFSET -9 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT RightShank\n{\nOFFSET 0 -42 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "JOINT RightFoot\n{\nOFFSET 0 -40 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 -6 "
    "15\n}\n}\n}\n}\n"
    "}\nMOTION\nFrames: 3\nFrame Time: 0.04\n";

inline std::string bvh_text_with(double elbow_deg, double step_cm) {
  std::string text(kBvh);
  for (int f = 0; f < 3; ++f) {
    // Hips 6, then 3 a joint: chest, head, left arm (upper, forearm, hand), right arm, left leg, right leg.
    std::vector<double> values(6 + 3 * 14, 0.0);
    values[1] = 88.0;
    if (f == 2) values[0] = step_cm;
    if (f > 0) values[6 + 3 * 3 + 2] = -elbow_deg;  // Yrotation of the left forearm: x (left) towards z (forward)
    for (const double value : values) text += std::to_string(value) + " ";
    text += "\n";
  }
  return text;
}

}  // namespace rotunda::tests
