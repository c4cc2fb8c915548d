#include "recon/body/captured_motion.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <system_error>

#include "capture/take/take.h"
#include "recon/mesh/mesh_file.h"

namespace rotunda::recon {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kCentimetres = 100.0;

// x forwards, y left, z up becomes z forwards, x left, y up.
Vector3d y_up(const Vector3d& v) {
  return {v.y(), v.z(), v.x()};
}
Matrix3d y_up(const Matrix3d& rotation) {
  Matrix3d from_ours;
  from_ours << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return from_ours * rotation * from_ours.transpose();
}

// R = Rz Rx Ry, degrees.
Vector3d zxy_degrees(const Matrix3d& r) {
  const double x = std::asin(std::clamp(r(2, 1), -1.0, 1.0));
  return Vector3d(std::atan2(-r(0, 1), r(1, 1)), x, std::atan2(-r(2, 0), r(2, 2))) * (180.0 / std::numbers::pi);
}

std::optional<Vector3d> end_of(const Skeleton& skeleton, BodyJoint joint) {
  switch (joint) {
    case BodyJoint::head:
      return skeleton.crown;
    case BodyJoint::hand_left:
      return skeleton.fingertip;
    case BodyJoint::hand_right:
      return skeleton.fingertip.cwiseProduct(Vector3d(1, -1, 1));
    case BodyJoint::foot_left:
    case BodyJoint::foot_right:
      return skeleton.toe;
    default:
      return std::nullopt;
  }
}

std::vector<BvhJoint> bvh_joints(const Skeleton& skeleton) {
  using enum BvhChannel;
  std::vector<BvhJoint> joints;
  std::array<int, kBodyJoints> place{};
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto joint = body_joint(j);
    const auto parent = parent_of(joint);
    place[j] = static_cast<int>(joints.size());
    joints.push_back({.name = std::string(to_string(joint)),
                      .parent = parent ? place[index(*parent)] : -1,
                      .offset = kCentimetres * y_up(skeleton.offset[j]),
                      .channels = {z_rotation, x_rotation, y_rotation}});
    if (!parent) joints.back().channels.insert(joints.back().channels.begin(), {x_position, y_position, z_position});
    if (const auto end = end_of(skeleton, joint))
      joints.push_back(
          {.name = "", .parent = place[j], .offset = kCentimetres * y_up(*end), .channels = {}, .is_end_site = true});
  }
  return joints;
}

std::string_view to_string(TrackState state) {
  switch (state) {
    case TrackState::tracked:
      return "tracked";
    case TrackState::recovered:
      return "recovered";
    case TrackState::lost:
      break;
  }
  return "lost";
}

nlohmann::json frame_json(const CapturedMotion& motion, std::size_t i) {
  const auto& frame = motion.frames[i];
  nlohmann::json json{{"frame", motion.first_frame + i},
                      {"state", to_string(frame.state)},
                      {"residual_m", frame.fit.residual},
                      {"confidence", frame.fit.confidence},
                      {"sigma_m", frame.fit.sigma}};
  if (!frame.loss.empty()) json["loss"] = frame.loss;
  for (const auto& p : joint_positions(motion.body.skeleton, frame.fit.pose))
    json["positions"].push_back({p.x(), p.y(), p.z()});
  for (const auto& q : frame.fit.pose.rotation) json["rotations"].push_back({q.w(), q.x(), q.y(), q.z()});
  return json;
}

}  // namespace

BvhMotion bvh_of(const CapturedMotion& motion) {
  BvhMotion bvh;
  bvh.joints = bvh_joints(motion.body.skeleton);
  bvh.frame_time = 1.0 / motion.fps;
  bvh.frames = motion.frames.size();
  for (const auto& frame : motion.frames) {
    const Vector3d root = kCentimetres * y_up(frame.fit.pose.root);
    bvh.values.insert(bvh.values.end(), {root.x(), root.y(), root.z()});
    for (const auto& rotation : frame.fit.pose.rotation) {
      const Vector3d angles = zxy_degrees(y_up(rotation.toRotationMatrix()));
      bvh.values.insert(bvh.values.end(), {angles.x(), angles.y(), angles.z()});
    }
  }
  return bvh;
}

void write_joints_json(const std::filesystem::path& file, const CapturedMotion& motion) {
  nlohmann::json json{{"unit", "m"}, {"fps", motion.fps}, {"height", height_of(motion.body.measures)}};
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto parent = parent_of(body_joint(j));
    json["joints"].push_back(
        {{"name", to_string(body_joint(j))}, {"parent", parent ? static_cast<int>(index(*parent)) : -1}});
  }
  for (std::size_t m = 0; m < kBodyMeasures; ++m)
    json["measures"][std::string(to_string(static_cast<BodyMeasure>(m)))] = motion.body.measures[m];
  for (std::size_t i = 0; i < motion.frames.size(); ++i) json["frames"].push_back(frame_json(motion, i));
  std::ofstream stream(file);
  stream << json.dump(1) << '\n';
  if (!stream.flush()) throw std::system_error(errno, std::generic_category(), file.string());
}

void write_template_meshes(const std::filesystem::path& folder, const CapturedMotion& motion) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < motion.frames.size(); ++i)
    write_ply(folder / capture::frame_file_name(motion.first_frame + i, "ply"),
              pose_template(motion.body, motion.frames[i].fit.pose));
}

}  // namespace rotunda::recon
