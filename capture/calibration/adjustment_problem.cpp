#include "capture/calibration/adjustment_problem.h"

#include <ceres/loss_function.h>
#include <ceres/normal_prior.h>
#include <ceres/rotation.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

namespace rotunda::capture {
namespace {

constexpr double kLossWidth = 2.5;  // noises

// What lenses are like before any picture is seen; standard deviations.
constexpr double kFocalLength = 1.2, kFocalPrior = 1.0;  // of the picture's longer side; natural logarithm
constexpr double kCentrePrior = 0.01;      // of the picture's longer side, about its middle
constexpr double kAspectPrior = 0.02;      // fy / fx about 1; video cameras have up to 16/15
constexpr double kTangentialPrior = 1e-3;  // p1, p2
constexpr double kSecondPrior = 0.1;       // k2
constexpr double kThirdPrior = 0.02;       // k3
constexpr double kFirstPrior = 1.0;        // k1
constexpr double kBendPrior = 0.005;       // per metre: 1 mm over half a metre

std::array<double, kPose> to_block(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  std::array<double, kPose> block{};
  ceres::RotationMatrixToAngleAxis(R.data(), block.data());  // both column by column
  Eigen::Map<Eigen::Vector3d>(block.data() + 3) = t;
  return block;
}

Eigen::Isometry3d to_isometry(const std::array<double, kPose>& block) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d R;
  ceres::AngleAxisToRotationMatrix(block.data(), R.data());
  pose.linear() = R;
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(block.data() + 3);
  return pose;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// A rotation vector's rotation, and how the turned point moves with the vector: -R [p]x Jr, where Jr is the right
// Jacobian of SO(3) (Sola et al. 2018, eq. 143).
struct Rotation {
  explicit Rotation(const double* vector) : w(vector[0], vector[1], vector[2]) {
    ceres::AngleAxisToRotationMatrix(vector, R.data());
  }
  Eigen::Matrix3d derivative(const Eigen::Vector3d& point) const {
    const double angle = w.norm();
    const Eigen::Matrix3d W = cross(w);
    Eigen::Matrix3d right = Eigen::Matrix3d::Identity() - 0.5 * W;
    if (angle > 1e-4)
      right = Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / (angle * angle) * W +
              (angle - std::sin(angle)) / (angle * angle * angle) * W * W;
    return -R * cross(point) * right;
  }
  Eigen::Vector3d w;
  Eigen::Matrix3d R;
};

// Where the lens of camera_model.h puts a point of the camera's frame, with derivatives by the point and the
// intrinsics.
struct Projected {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, kIntrinsics> by_intrinsics;
};

Projected projected(const double* intrinsics, double skew, const Eigen::Vector3d& point) {
  const double x = point.x() / point.z(), y = point.y() / point.z(), r2 = x * x + y * y;
  const double *f = intrinsics, *c = intrinsics + 2, *k = intrinsics + 4;  // k: k1 k2 p1 p2 k3
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double slope = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]);  // of radial, by r2
  const double u = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
  const double v = y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
  Eigen::Matrix2d A, D;
  A << f[0], skew, 0.0, f[1];
  const double mixed = 2.0 * (x * y * slope + k[2] * x + k[3] * y);
  D << radial + 2.0 * x * x * slope + 2.0 * k[2] * y + 6.0 * k[3] * x, mixed,  //
      mixed, radial + 2.0 * y * y * slope + 6.0 * k[2] * y + 2.0 * k[3] * x;
  Eigen::Matrix<double, 2, 3> ideal;
  ideal << 1.0, 0.0, -x, 0.0, 1.0, -y;
  Eigen::Matrix<double, 2, 5> by_distortion;
  by_distortion << x * r2, x * r2 * r2, 2.0 * x * y, r2 + 2.0 * x * x, x * r2 * r2 * r2,  //
      y * r2, y * r2 * r2, r2 + 2.0 * y * y, 2.0 * x * y, y * r2 * r2 * r2;
  Projected result;
  result.pixel = Eigen::Vector2d(f[0] * u + skew * v + c[0], f[1] * v + c[1]);
  result.by_point = A * D * ideal / point.z();
  result.by_intrinsics.setZero();
  result.by_intrinsics(0, 0) = u, result.by_intrinsics(1, 1) = v;
  result.by_intrinsics(0, 2) = 1.0, result.by_intrinsics(1, 3) = 1.0;
  result.by_intrinsics.rightCols<5>() = A * by_distortion;
  return result;
}

// Calibrated minus found, in units of the noise. Parameters: intrinsics, camera_from_world, world_from_board, bend.
class CornerOff : public ceres::SizedCostFunction<2, kIntrinsics, kPose, kPose, 3> {
 public:
  CornerOff(const Eigen::Vector3d& on_board, const Eigen::Vector2d& pixel, double skew, double weight)
      : on_board_(on_board), pixel_(pixel), skew_(skew), weight_(weight) {}

  bool Evaluate(const double* const* parameters, double* off, double** jacobians) const override {
    const double x = on_board_.x(), y = on_board_.y();
    const Eigen::Vector3d squares(x * x, x * y, y * y);
    const Eigen::Vector3d point(x, y, Eigen::Map<const Eigen::Vector3d>(parameters[3]).dot(squares));
    const Rotation board(parameters[2]), camera(parameters[1]);
    const Eigen::Vector3d in_world = board.R * point + Eigen::Map<const Eigen::Vector3d>(parameters[2] + 3);
    const Eigen::Vector3d in_camera = camera.R * in_world + Eigen::Map<const Eigen::Vector3d>(parameters[1] + 3);
    if (in_camera.z() < kNearest) return false;
    const auto seen = projected(parameters[0], skew_, in_camera);
    Eigen::Map<Eigen::Vector2d>{off} = weight_ * (seen.pixel - pixel_);
    if (jacobians == nullptr) return true;
    using Pose = Eigen::Map<Eigen::Matrix<double, 2, kPose, Eigen::RowMajor>>;
    const Eigen::Matrix<double, 2, 3> by_camera = weight_ * seen.by_point, by_world = by_camera * camera.R;
    if (jacobians[0] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor>>{jacobians[0]} = weight_ * seen.by_intrinsics;
    if (jacobians[1] != nullptr) Pose{jacobians[1]} << by_camera * camera.derivative(in_world), by_camera;
    if (jacobians[2] != nullptr) Pose{jacobians[2]} << by_world * board.derivative(point), by_world;
    if (jacobians[3] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[3]} =
          by_world * board.R.col(2) * squares.transpose();
    return true;
  }

 private:
  static constexpr double kNearest = 1e-3;  // metres before the camera
  Eigen::Vector3d on_board_;
  Eigen::Vector2d pixel_;
  double skew_, weight_;
};

// fy / fx, cx, cy, k1, k2, p1, p2, k3 and fx about what lenses have.
class IntrinsicsPrior : public ceres::SizedCostFunction<9, kIntrinsics> {
 public:
  explicit IntrinsicsPrior(const CameraModel& camera) {
    const double centre = kCentrePrior * std::max(camera.width, camera.height);
    middle_ = {0.5 * (camera.width - 1), 0.5 * (camera.height - 1), 0, 0, 0, 0, 0};
    usual_fx_ = kFocalLength * std::max(camera.width, camera.height);
    deviation_ = {centre, centre, kFirstPrior, kSecondPrior, kTangentialPrior, kTangentialPrior, kThirdPrior};
  }
  bool Evaluate(const double* const* parameters, double* off, double** jacobians) const override {
    const double* in = parameters[0];
    off[0] = (in[1] / in[0] - 1.0) / kAspectPrior;
    for (std::size_t i = 0; i < middle_.size(); ++i) off[i + 1] = (in[i + 2] - middle_[i]) / deviation_[i];
    if (!(in[0] > 0.0)) return false;
    off[8] = std::log(in[0] / usual_fx_) / kFocalPrior;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 9, kIntrinsics, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J(0, 0) = -in[1] / (in[0] * in[0]) / kAspectPrior;
    J(0, 1) = 1.0 / in[0] / kAspectPrior;
    J(8, 0) = 1.0 / in[0] / kFocalPrior;
    for (int i = 0; i < 7; ++i) J(i + 1, i + 2) = 1.0 / deviation_[static_cast<std::size_t>(i)];
    return true;
  }

 private:
  std::array<double, 7> middle_{}, deviation_{};
  double usual_fx_ = 0.0;
};

CameraBlocks to_blocks(const CameraModel& camera) {
  CameraBlocks blocks;
  blocks.intrinsics = {camera.K(0, 0),       camera.K(1, 1),       camera.K(0, 2),
                       camera.K(1, 2),       camera.distortion[0], camera.distortion[1],
                       camera.distortion[2], camera.distortion[3], camera.distortion[4]};
  blocks.camera_from_world = to_block(camera.R, camera.t);
  return blocks;
}

}  // namespace

AdjustmentProblem::AdjustmentProblem(const RigState& state, std::span<const Sighting> sightings,
                                     std::span<const Board> boards, const AdjustmentOptions& options, double noise_px)
    : noise_px_(noise_px),
      seen_(state.cameras.size(), 0),
      bends_(boards.size()),
      problem_(std::make_unique<ceres::Problem>()) {
  for (const auto& camera : state.cameras) cameras_.push_back(to_blocks(camera));
  for (std::size_t i = 0; i < std::min(boards.size(), state.bends.size()); ++i)
    bends_[i] = {state.bends[i].xx, state.bends[i].xy, state.bends[i].yy};
  for (const auto& sighting : sightings) {
    const auto pose = state.world_from_board.find({sighting.moment, sighting.board});
    if (sighting.camera >= cameras_.size() || pose == state.world_from_board.end() || sighting.corners.empty())
      continue;
    boards_.try_emplace(pose->first, to_block(pose->second.linear(), pose->second.translation()));
    add_corners(sighting, boards[sighting.board], state.cameras[sighting.camera]);
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i)
    if (seen_[i] > 0) add_priors(i, state.cameras[i]);
  hold_what_is_kept(options);
}

void AdjustmentProblem::add_corners(const Sighting& sighting, const Board& board, const CameraModel& model) {
  const auto positions = corner_positions(board);
  auto& camera = cameras_[sighting.camera];
  auto& pose = boards_.at({sighting.moment, sighting.board});
  auto* loss = new ceres::SoftLOneLoss(kLossWidth);  // one a sighting; the problem owns it
  for (const auto& corner : sighting.corners) {
    auto* off =
        new CornerOff(positions[static_cast<std::size_t>(corner.corner)], corner.pixel, model.K(0, 1), 1.0 / noise_px_);
    problem_->AddResidualBlock(off, loss, camera.intrinsics.data(), camera.camera_from_world.data(), pose.data(),
                               bends_[sighting.board].data());
  }
  seen_[sighting.camera] += static_cast<int>(sighting.corners.size());
  corners_ += sighting.corners.size();
}

void AdjustmentProblem::add_priors(std::size_t camera, const CameraModel& model) {
  problem_->AddResidualBlock(new IntrinsicsPrior(model), nullptr, cameras_[camera].intrinsics.data());
}

void AdjustmentProblem::hold_what_is_kept(const AdjustmentOptions& options) {
  bool held = false;  // the world, by the first camera that sees anything
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (seen_[i] == 0) continue;
    if (options.keep_intrinsics || options.keep_cameras)
      problem_->SetParameterBlockConstant(cameras_[i].intrinsics.data());
    if (options.keep_cameras || !held) problem_->SetParameterBlockConstant(cameras_[i].camera_from_world.data());
    held = true;
  }
  for (auto& bend : bends_) {
    if (!problem_->HasParameterBlock(bend.data())) continue;
    if (!options.bend || options.keep_cameras) {
      problem_->SetParameterBlockConstant(bend.data());
      continue;
    }
    const ceres::Matrix weights = ceres::Matrix::Identity(3, 3) / kBendPrior;
    problem_->AddResidualBlock(new ceres::NormalPrior(weights, ceres::Vector::Zero(3)), nullptr, bend.data());
  }
}

bool AdjustmentProblem::solve(double& cost) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;  // more would sum in another order
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (auto& [key, pose] : boards_) ordering->AddElementToGroup(pose.data(), 0);
  for (auto& camera : cameras_)
    for (double* block : {camera.intrinsics.data(), camera.camera_from_world.data()})
      if (problem_->HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
  for (auto& bend : bends_)
    if (problem_->HasParameterBlock(bend.data())) ordering->AddElementToGroup(bend.data(), 1);
  options.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem_.get(), &summary);
  cost = summary.final_cost;
  return summary.termination_type == ceres::CONVERGENCE;
}

void AdjustmentProblem::write_to(RigState& state) const {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (seen_[i] == 0) continue;
    auto& camera = state.cameras[i];
    const auto& in = cameras_[i].intrinsics;
    camera.K(0, 0) = in[0], camera.K(1, 1) = in[1], camera.K(0, 2) = in[2], camera.K(1, 2) = in[3];
    for (int k = 0; k < 5; ++k) camera.distortion[k] = in[4 + static_cast<std::size_t>(k)];
    const auto pose = to_isometry(cameras_[i].camera_from_world);
    camera.R = pose.linear();
    camera.t = pose.translation();
  }
  for (const auto& [key, block] : boards_) state.world_from_board[key] = to_isometry(block);
  for (std::size_t i = 0; i < bends_.size(); ++i) state.bends[i] = {bends_[i][0], bends_[i][1], bends_[i][2]};
}

}  // namespace rotunda::capture
