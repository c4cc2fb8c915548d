#include "capture/calibration/projection_matrix.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <cmath>
#include <optional>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kParallel = 0.01;  // radians between axes; flatter and their common point is anywhere

// M = K R with K upper triangular, its diagonal positive, R orthonormal: with J the matrix that turns the order of rows
// round, (J M)^T = Q U gives M = (J U^T J) (J Q^T).
void split(const Eigen::Matrix3d& M, Eigen::Matrix3d& K, Eigen::Matrix3d& R) {
  const Eigen::Matrix3d turned = M.colwise().reverse().transpose();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(turned);
  const Eigen::Matrix3d Q = qr.householderQ();
  const Eigen::Matrix3d U = qr.matrixQR().triangularView<Eigen::Upper>();
  K = U.transpose().reverse();
  R = Q.transpose().colwise().reverse();
  const Eigen::Vector3d sign(K(0, 0) < 0 ? -1 : 1, K(1, 1) < 0 ? -1 : 1, K(2, 2) < 0 ? -1 : 1);
  K = Eigen::Matrix3d(K * sign.asDiagonal());
  R = Eigen::Matrix3d(sign.asDiagonal() * R);
}

// As given, sign and all: x_cam = R x + t with z's sign undecided.
CameraModel decompose_one(const ProjectionMatrix& given, const std::string& name) {
  if (!given.allFinite()) throw InvalidInput(name + ": every number of a projection matrix must be finite");
  // The third row's length is the factor of K[2][2] = 1; dividing first keeps products within range.
  const double scale = given.leftCols<3>().row(2).norm();
  const Eigen::JacobiSVD<Eigen::Matrix3d> size(given.leftCols<3>());
  if (!(scale > 0.0) || !(size.singularValues()[2] > 1e-12 * size.singularValues()[0]))
    throw InvalidInput(name + ": its projection matrix has no centre (the left 3 x 3 part cannot be inverted)");
  const ProjectionMatrix P = given / scale;
  CameraModel camera;
  camera.name = name;
  Eigen::Matrix3d K;
  split(P.leftCols<3>(), K, camera.R);
  camera.t = K.triangularView<Eigen::Upper>().solve(P.col(3));
  camera.K = K / K(2, 2);
  return camera;
}

// The point nearest to all optical axes; none if they are nearly parallel.
std::optional<Eigen::Vector3d> looked_at(std::span<const CameraModel> cameras) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const auto& camera : cameras) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - camera.axis() * camera.axis().transpose();
    sum += across;
    right += across * camera.centre();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
  // n lines at angle a to each other: the smallest eigenvalue is about n sin^2(a / 2).
  if (solver.eigenvalues()[0] < kParallel * kParallel / 4 * static_cast<double>(cameras.size())) return std::nullopt;
  return sum.ldlt().solve(right);
}

void turn_round(CameraModel& camera) {
  camera.R = -camera.R;
  camera.t = -camera.t;
}

}  // namespace

ProjectionMatrix projection_matrix(const CameraModel& camera) {
  ProjectionMatrix pose;
  pose << camera.R, camera.t;
  return camera.K * pose;
}

DecomposedProjections decompose(std::span<const ProjectionMatrix> projections, std::span<const std::string> names) {
  DecomposedProjections result;
  for (std::size_t i = 0; i < projections.size(); ++i)
    result.cameras.push_back(decompose_one(projections[i], names[i]));
  const auto target = looked_at(result.cameras);
  std::vector<std::string> mirrored;
  for (auto& camera : result.cameras) {
    const bool behind = target ? (camera.R * *target + camera.t).z() < 0.0 : camera.R.determinant() < 0.0;
    if (behind) turn_round(camera);
    if (camera.R.determinant() < 0.0) mirrored.push_back(camera.name);
  }
  if (!mirrored.empty() && mirrored.size() < result.cameras.size())
    throw InvalidInput(fmt::format(
        "{} of {} cameras are mirror images of the others ({}): the projection matrices are not of one world; were "
        "some pictures flipped?",
        mirrored.size(), result.cameras.size(), fmt::join(mirrored, ", ")));
  if (!mirrored.empty()) result.handedness = Handedness::left;
  return result;
}

}  // namespace rotunda::capture
