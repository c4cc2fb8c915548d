#include "capture/calibration/calibration_covariance.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/Sparse>
#include <cmath>
#include <numbers>

#include "capture/calibration/adjustment_problem.h"

namespace rotunda::capture {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Pose6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kIn = static_cast<int>(kIntrinsics);

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The blocks that vary, cameras' first, with where each camera's columns begin (-1: held or unseen).
struct Layout {
  std::vector<double*> blocks;
  std::vector<int> intrinsics, pose;
  int camera_columns = 0;  // with the boards' bending
};

Layout layout_of(AdjustmentProblem& problem) {
  Layout layout;
  const auto add = [&](double* block, int size) {
    if (!problem.problem().HasParameterBlock(block) || problem.problem().IsParameterBlockConstant(block)) return -1;
    layout.blocks.push_back(block);
    layout.camera_columns += size;
    return layout.camera_columns - size;
  };
  for (auto& camera : problem.cameras()) {
    layout.intrinsics.push_back(add(camera.intrinsics.data(), kIn));
    layout.pose.push_back(add(camera.camera_from_world.data(), static_cast<int>(kPose)));
  }
  for (auto& bend : problem.bends()) add(bend.data(), 3);
  for (auto& [key, pose] : problem.boards()) layout.blocks.push_back(pose.data());
  return layout;
}

// The normal equations of the cameras alone: each board's six unknowns are eliminated (Schur complement).
std::optional<MatrixXd> reduced_normal_equations(AdjustmentProblem& problem, const Layout& layout) {
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.parameter_blocks = layout.blocks;
  ceres::CRSMatrix crs;
  if (!problem.problem().Evaluate(evaluate, nullptr, nullptr, nullptr, &crs)) return std::nullopt;
  const Eigen::Map<const Rows> J(crs.num_rows, crs.num_cols, static_cast<int>(crs.values.size()), crs.rows.data(),
                                 crs.cols.data(), crs.values.data());
  const Eigen::SparseMatrix<double> normal = J.transpose() * J;
  const int n = layout.camera_columns;
  MatrixXd reduced = normal.topLeftCorner(n, n);
  for (int board = n; board + 6 <= crs.num_cols; board += 6) {
    const Matrix6 own = MatrixXd(normal.block(board, board, 6, 6));
    const MatrixXd tie = normal.block(0, board, n, 6);
    const Eigen::LDLT<Matrix6> inverse(own);
    if (inverse.info() != Eigen::Success || !inverse.isPositive()) return std::nullopt;
    reduced -= tie * inverse.solve(tie.transpose());
  }
  return reduced;
}

// Rotation in world and centre by the adjustment's rotation vector and translation.
Matrix6 world_by_block(const std::array<double, kPose>& block) {
  const auto world_of = [](const Pose6& p) {
    const Vector3d axis = p.head<3>();
    const Matrix3d R = axis.norm() > 0 ? Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix()
                                       : Matrix3d(Matrix3d::Identity());
    return std::pair<Matrix3d, Vector3d>{R, -R.transpose() * p.tail<3>()};
  };
  const Pose6 at = Eigen::Map<const Pose6>(block.data());
  const Matrix3d R0 = world_of(at).first;
  constexpr double kStep = 1e-6;
  Matrix6 J;
  for (int i = 0; i < 6; ++i) {
    Pose6 up = at, down = at;
    up[i] += kStep, down[i] -= kStep;
    const auto [R_up, c_up] = world_of(up);
    const auto [R_down, c_down] = world_of(down);
    const Matrix3d turn = R0.transpose() * (R_up - R_down) / (2.0 * kStep);  // camera_from_world's, seen in world
    J.col(i).head<3>() = -Vector3d(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1)) / 2.0;
    J.col(i).tail<3>() = (c_up - c_down) / (2.0 * kStep);
  }
  return J;
}

// Takes out what a rigid alignment of all centres would: rows of rotations and centres of the cameras that are seen.
void align_centres(const RigState& state, const std::vector<bool>& seen, MatrixXd& covariance) {
  const auto size = covariance.rows();
  MatrixXd G = MatrixXd::Zero(size, 6), centres = MatrixXd::Zero(size, 6);
  Vector3d middle = Vector3d::Zero();
  double count = 0;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i]) middle += state.cameras[i].centre(), count += 1;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    const auto row = static_cast<Eigen::Index>(i) * kCameraUnknowns + kIn;
    G.block<3, 3>(row, 0) = Matrix3d::Identity();
    centres.block<3, 3>(row + 3, 0) = -cross(state.cameras[i].centre() - middle / count);
    centres.block<3, 3>(row + 3, 3) = Matrix3d::Identity();
  }
  G += centres;
  const MatrixXd rigid = centres.transpose() * centres;
  const MatrixXd P =
      MatrixXd::Identity(size, size) - G * rigid.completeOrthogonalDecomposition().solve(centres.transpose());
  covariance = P * covariance * P.transpose();
}

}  // namespace

MatrixXd camera_covariance(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                           const AdjustmentOptions& options, double noise_px) {
  AdjustmentProblem problem(state, sightings, boards, options, noise_px);
  const Layout layout = layout_of(problem);
  const auto normal = reduced_normal_equations(problem, layout);
  if (!normal) return {};
  const Eigen::LDLT<MatrixXd> solver(*normal);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return {};
  const MatrixXd inverse = solver.solve(MatrixXd::Identity(normal->rows(), normal->cols()));
  const auto cameras = static_cast<Eigen::Index>(state.cameras.size());
  MatrixXd world_by_blocks = MatrixXd::Zero(cameras * kCameraUnknowns, inverse.rows());
  std::vector<bool> seen;
  for (std::size_t i = 0; i < state.cameras.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i) * kCameraUnknowns;
    auto& blocks = problem.cameras()[i];
    seen.push_back(problem.problem().HasParameterBlock(blocks.camera_from_world.data()));
    if (layout.intrinsics[i] >= 0) world_by_blocks.block(row, layout.intrinsics[i], kIn, kIn).setIdentity();
    if (layout.pose[i] >= 0)
      world_by_blocks.block<6, 6>(row + kIn, layout.pose[i]) = world_by_block(blocks.camera_from_world);
  }
  MatrixXd covariance = world_by_blocks * inverse * world_by_blocks.transpose();
  if (!covariance.allFinite()) return {};
  align_centres(state, seen, covariance);
  return covariance;
}

CameraDeviation deviation_of(const MatrixXd& covariance, std::size_t camera) {
  CameraDeviation deviation;
  if (covariance.size() == 0) return deviation;
  const Eigen::VectorXd variance =
      covariance.diagonal().segment<kCameraUnknowns>(static_cast<Eigen::Index>(camera) * kCameraUnknowns).cwiseMax(0.0);
  deviation.fx = std::sqrt(variance[0]), deviation.fy = std::sqrt(variance[1]);
  deviation.cx = std::sqrt(variance[2]), deviation.cy = std::sqrt(variance[3]);
  deviation.distortion = variance.segment<5>(4).cwiseSqrt();
  deviation.rotation_deg = std::sqrt(variance.segment<3>(kIn).sum()) * 180.0 / std::numbers::pi;
  deviation.centre = std::sqrt(variance.segment<3>(kIn + 3).sum());
  return deviation;
}

double baseline_deviation(const MatrixXd& covariance, const RigState& state, std::size_t a, std::size_t b) {
  if (covariance.size() == 0) return 0.0;
  const Vector3d along = (state.cameras[a].centre() - state.cameras[b].centre()).normalized();
  Eigen::VectorXd by = Eigen::VectorXd::Zero(covariance.rows());
  by.segment<3>(static_cast<Eigen::Index>(a) * kCameraUnknowns + kIn + 3) = along;
  by.segment<3>(static_cast<Eigen::Index>(b) * kCameraUnknowns + kIn + 3) = -along;
  return std::sqrt(std::max(0.0, by.dot(covariance * by)));
}

double expected_reprojection(const MatrixXd& covariance, const RigState& state, std::size_t camera,
                             std::span<const Vector3d> points) {
  if (covariance.size() == 0) return 0.0;
  const auto place = static_cast<Eigen::Index>(camera) * kCameraUnknowns;
  const MatrixXd own = covariance.block<kCameraUnknowns, kCameraUnknowns>(place, place);
  const auto changed = [&](int unknown, double by) {
    CameraModel model = state.cameras[camera];
    if (unknown < 2) model.K(unknown, unknown) += by;
    if (unknown == 2 || unknown == 3) model.K(unknown - 2, 2) += by;
    if (unknown >= 4 && unknown < kIn) model.distortion[unknown - 4] += by;
    Vector3d centre = model.centre();
    if (unknown >= kIn && unknown < kIn + 3)  // the camera turned in the world
      model.R = Matrix3d(model.R * Eigen::AngleAxisd(-by, Vector3d::Unit(unknown - kIn)).toRotationMatrix());
    if (unknown >= kIn + 3) centre[unknown - kIn - 3] += by;
    model.t = -model.R * centre;
    return model;
  };
  constexpr double kStep = 1e-6;
  double sum = 0.0;
  int count = 0;
  for (const auto& point : points) {
    Eigen::Matrix<double, 2, kCameraUnknowns> J;
    bool seen = true;
    for (int i = 0; i < kCameraUnknowns && seen; ++i) {
      const auto up = project(changed(i, kStep), point), down = project(changed(i, -kStep), point);
      seen = up && down;
      if (seen) J.col(i) = (*up - *down) / (2.0 * kStep);
    }
    if (!seen) continue;
    sum += (J * own * J.transpose()).trace();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace rotunda::capture
