#include "recon/track/skinned_prior.h"

#include <Eigen/Geometry>

namespace rotunda::recon {
namespace {

constexpr double kAnywhere = 1.0;  // metres: every point of the surface belongs to some segment

// The joint whose segment each vertex of the surface lies on: the nearest of those that face as it does.
std::vector<std::size_t> joints_of(const TriangleMesh& surface, const BodyTemplate& body, const Pose& pose) {
  const auto posed = pose_template(body, pose);
  const SurfaceTarget target(posed);
  std::vector<std::size_t> joints(surface.positions.size(), index(BodyJoint::pelvis));
  for (std::size_t v = 0; v < joints.size(); ++v) {
    const auto near =
        target.closest_vertex(surface.positions[v].cast<double>(), surface.normals[v].cast<double>(), kAnywhere);
    if (near) joints[v] = index(joint_of_segment(*near / vertices_of_segment()));
  }
  return joints;
}

Eigen::Quaterniond blended(const SkinnedPrior::Weights& weights,
                           const std::array<Eigen::Quaterniond, kBodyJoints>& turns) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  Eigen::Vector4d first = Eigen::Vector4d::Zero();
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    if (weights[j] <= 0.0) continue;
    const Eigen::Vector4d turn = turns[j].coeffs();
    if (first.isZero()) first = turn;
    sum += (turn.dot(first) < 0.0 ? -weights[j] : weights[j]) * turn;
  }
  return Eigen::Quaterniond(sum).normalized();
}

}  // namespace

SkinnedPrior::SkinnedPrior(const SurfaceModel& model, const BodyTemplate& body, const Pose& at_rest) : model_(model) {
  rest_from_joint_inverse_ = joint_transforms(body.skeleton, at_rest);
  for (auto& transform : rest_from_joint_inverse_) transform = transform.inverse();
  const auto joints = joints_of(model.rest(), body, at_rest);
  const auto areas = vertex_areas(model.rest());
  weights_.assign(model.graph().nodes.size(), Weights{});
  for (std::size_t v = 0; v < joints.size(); ++v) {
    const auto& binding = model.graph().bindings[v];
    for (std::size_t k = 0; k < DeformationGraph::kNearest; ++k)
      weights_[binding.node[k]][joints[v]] += binding.weight[k] * areas[v];
  }
  for (auto& weights : weights_) {
    double sum = 0.0;
    for (const double weight : weights) sum += weight;
    if (!(sum > 0.0)) weights[index(BodyJoint::pelvis)] = sum = 1.0;
    for (double& weight : weights) weight /= sum;
  }
}

std::vector<NodeMotion> SkinnedPrior::posed(const Skeleton& skeleton, const Pose& pose) const {
  auto moves = joint_transforms(skeleton, pose);
  std::array<Eigen::Quaterniond, kBodyJoints> turns;
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    moves[j] = moves[j] * rest_from_joint_inverse_[j];
    turns[j] = Eigen::Quaterniond(moves[j].linear());
  }
  std::vector<NodeMotion> motion(weights_.size());
  for (std::size_t n = 0; n < motion.size(); ++n) {
    const auto& node = model_.graph().nodes[n];
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < kBodyJoints; ++j)
      if (weights_[n][j] > 0.0) place += weights_[n][j] * (moves[j] * node);
    motion[n] = {blended(weights_[n], turns).toRotationMatrix(), place - node};
  }
  return motion;
}

}  // namespace rotunda::recon
