#include "recon/body/pose_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "recon/body/body_capsules.h"

namespace rotunda::recon {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLimitSigma = 0.03;  // radians beyond a joint's range
// How far joints are from the middle of what people mostly do, radians: only for what silhouettes leave open.
constexpr double kBallSigma = 1.2, kTrunkSigma = 0.35, kSmallSigma = 0.5, kClavicleSigma = 0.2;

Index twists() {
  return static_cast<Index>(pose_twists().size());
}

NormalEquations empty_equations(Index size) {
  NormalEquations equations;
  equations.H.setZero(size, size);
  equations.g.setZero(size);
  return equations;
}

Vector3d rotation_vector(const Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation.w() < 0.0 ? Quaterniond(-rotation.coeffs()) : rotation);
  return turn.angle() * turn.axis();
}

std::vector<std::uint16_t> own_twists(std::size_t joint) {
  std::vector<std::uint16_t> own;
  for (std::size_t k = 0; k < pose_twists().size(); ++k)
    if (index(pose_twists()[k].joint) == joint && pose_twists()[k].kind != Twist::Kind::translation)
      own.push_back(static_cast<std::uint16_t>(k));
  return own;
}

const std::array<std::vector<std::uint16_t>, kBodyJoints>& own_twists() {
  static const auto all = [] {
    std::array<std::vector<std::uint16_t>, kBodyJoints> list;
    for (std::size_t j = 0; j < kBodyJoints; ++j) list[j] = own_twists(j);
    return list;
  }();
  return all;
}

Quaterniond turned(const Quaterniond& rotation, const Twist& twist, double angle) {
  const Quaterniond turn(Eigen::AngleAxisd(angle, twist.axis));
  return twist.kind == Twist::Kind::parent_axis ? turn * rotation : rotation * turn;
}

// A joint's vector-valued wish: rows of (value by twists), each with its weight; the derivative by difference, for a
// joint has three twists at most.
template <class Value>
void add_joint_rows(NormalEquations& equations, const Pose& pose, std::size_t j, const Value& value,
                    const Vector3d& weights) {
  constexpr double kStep = 1e-6;
  const auto& columns = own_twists()[j];
  if (columns.empty()) return;
  const Vector3d here = value(pose.rotation[j]);
  std::array<Vector3d, 3> by_twist = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 0; i < columns.size(); ++i)
    by_twist[i] = (value(turned(pose.rotation[j], pose_twists()[columns[i]], kStep)) - here) / kStep;
  constexpr double kWrapped = 1e3;  // coordinates jump where a turn goes past half a circle
  for (const auto& slope : by_twist)
    if (slope.cwiseAbs().maxCoeff() > kWrapped) return;
  for (int row = 0; row < 3; ++row) {
    if (here[row] == 0.0 && by_twist[0][row] == 0.0) continue;
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < columns.size(); ++i) values[i] = by_twist[i][row];
    equations.add(columns, values.data(), here[row], weights[row]);
  }
}

void add_limits(NormalEquations& equations, const Pose& pose) {
  for (std::size_t j = 1; j < kBodyJoints; ++j) {
    const auto& range = range_of(body_joint(j));
    const auto beyond = [&](const Quaterniond& rotation) -> Vector3d {
      const Vector3d c = range_coordinates(range, rotation);
      return c - c.cwiseMax(range.low).cwiseMin(range.high);
    };
    add_joint_rows(equations, pose, j, beyond, Vector3d::Constant(1.0 / (kLimitSigma * kLimitSigma)));
  }
}

double anatomy_sigma(BodyJoint joint) {
  switch (joint) {
    case BodyJoint::spine:
    case BodyJoint::chest:
      return kTrunkSigma;
    case BodyJoint::clavicle_left:
    case BodyJoint::clavicle_right:
      return kClavicleSigma;
    case BodyJoint::neck:
    case BodyJoint::hand_left:
    case BodyJoint::hand_right:
    case BodyJoint::foot_left:
    case BodyJoint::foot_right:
      return kSmallSigma;
    default:
      return kBallSigma;
  }
}

void add_anatomy(NormalEquations& equations, const Pose& pose) {
  for (std::size_t j = 1; j < kBodyJoints; ++j) {
    const auto& range = range_of(body_joint(j));
    const double sigma = anatomy_sigma(body_joint(j));
    add_joint_rows(
        equations, pose, j, [&](const Quaterniond& rotation) { return range_coordinates(range, rotation); },
        Vector3d::Constant(1.0 / (sigma * sigma)));
  }
}

void add_expected(NormalEquations& equations, const Pose& pose, const Pose& expected, double sigma) {
  const double weight = 1.0 / (sigma * sigma);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto away = [&](const Quaterniond& rotation) {
      return rotation_vector(expected.rotation[j].conjugate() * rotation);
    };
    add_joint_rows(equations, pose, j, away, Vector3d::Constant(weight));
  }
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    const double one = 1.0;
    equations.add({axis}, &one, pose.root[axis] - expected.root[axis], 16.0 * weight);
  }
}

void add_priors(NormalEquations& equations, const BodyTemplate& body, const Pose& pose, const PoseFitOptions& options) {
  add_limits(equations, pose);
  add_anatomy(equations, pose);
  if (options.only_overlap) return;
  add_capsules(equations, body, pose);
  if (options.expected) add_expected(equations, pose, *options.expected, options.expected_sigma);
}

VectorXd damped_step(const NormalEquations& equations) {
  MatrixXd H = equations.H.selfadjointView<Eigen::Lower>();
  H.diagonal() *= 1.0 + 1e-3;
  H.diagonal().array() += 1.0;
  return -H.ldlt().solve(equations.g);
}

// A step is believed up to half a radian, a quarter of a metre.
VectorXd shortened(VectorXd step) {
  const double turn = step.tail(step.size() - 3).cwiseAbs().maxCoeff(), way = step.head(3).cwiseAbs().maxCoeff();
  return step / std::max({1.0, turn / 0.5, way / 0.25});
}

double scale_at(const PoseFitOptions& options, int iteration) {
  const double share = options.iterations < 2 ? 1.0 : static_cast<double>(iteration) / (options.iterations - 1);
  return options.first_scale * std::pow(options.last_scale / options.first_scale, share);
}

// Of joints, out of the normal equations: twists' covariance carried to positions; and how much of the rim of the
// segments about a joint lies on the outline.
void judge(PoseFit& fit, const BodyTemplate& body, const NormalEquations& equations, const OutlineAgreement& seen) {
  const MatrixXd covariance =
      MatrixXd(equations.H.selfadjointView<Eigen::Lower>()).ldlt().solve(MatrixXd::Identity(twists(), twists()));
  const auto transforms = joint_transforms(body.skeleton, fit.pose);
  const double worse = std::max(1.0, fit.residual / 0.012);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    MatrixXd by_twist = MatrixXd::Zero(3, twists());
    for (const auto k : twists_of(body_joint(j))) {
      const auto& twist = pose_twists()[k];
      const auto& own = transforms[index(twist.joint)];
      const auto parent = parent_of(twist.joint);
      if (twist.kind == Twist::Kind::translation) {
        by_twist.col(k) = twist.axis;
        continue;
      }
      const bool of_parent = twist.kind == Twist::Kind::parent_axis && parent;
      const Vector3d axis = (of_parent ? transforms[index(*parent)] : own).linear() * twist.axis;
      by_twist.col(k) = axis.cross(transforms[j].translation() - own.translation());
    }
    fit.sigma[j] = worse * std::sqrt(std::max(0.0, (by_twist * covariance * by_twist.transpose()).trace()));
  }
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    std::size_t rim = 0, on = 0;
    for (std::size_t s = 0; s < kBodySegments; ++s) {
      const auto joint = joint_of_segment(s);
      if (index(joint) != j && parent_of(joint) != body_joint(j) && parent_of(body_joint(j)) != joint) continue;
      rim += seen.segment_rim[s];
      on += seen.segment_on_outline[s];
    }
    const double share = rim == 0 ? 0.0 : static_cast<double>(on) / static_cast<double>(rim);
    constexpr double kGoodSigma = 0.04;  // metres: a joint no better known than its limb's width
    const double ratio = fit.sigma[j] / kGoodSigma;
    fit.confidence[j] = share * std::exp(-0.5 * ratio * ratio);
  }
}

// A template's faults are the same along a limb and in every frame: so many points, and all frames, say the same once.
constexpr double kAlike = 20.0;

// Of lengths and widths against an adult's of the same height: lengths vary by about 4 % (Drillis, Contini 1966),
// widths by 15 %, and clothes make them anything.
void add_measure_prior(MatrixXd& H, VectorXd& g, const BodyMeasures& measures, const BodyMeasures& expected) {
  for (std::size_t m = 0; m < kBodyMeasures; ++m) {
    const bool is_length = m <= index(BodyMeasure::foot_height);
    const double sigma = (is_length ? 0.04 : 0.50) * expected[m];
    const auto i = static_cast<Index>(m);
    H(i, i) += 1.0 / (sigma * sigma);
    g[i] += (measures[m] - expected[m]) / (sigma * sigma);
  }
}

}  // namespace

PoseFit fit_pose(const BodyTemplate& body, const FrameOutlines& frame, const Pose& start,
                 const PoseFitOptions& options) {
  PoseFit fit{.pose = start};
  SilhouetteTermOptions term{.spacing_px = options.spacing_px};
  for (int i = 0; i < options.iterations; ++i) {
    auto equations = empty_equations(twists());
    term.robust_scale = scale_at(options, i);
    add_silhouettes(equations, body, fit.pose, frame, term);
    add_priors(equations, body, fit.pose, options);
    fit.pose = moved(fit.pose, shortened(damped_step(equations)));
  }
  auto equations = empty_equations(twists());
  const auto seen = add_silhouettes(equations, body, fit.pose, frame, term);
  add_priors(equations, body, fit.pose, options);
  fit.residual = seen.rms();
  fit.explained = seen.share();
  judge(fit, body, equations, seen);
  return fit;
}

BodyFit fit_body(const BodyTemplate& body, std::span<const FrameOutlines> frames, std::span<const Pose> poses,
                 int iterations) {
  BodyFit fit{body, {poses.begin(), poses.end()}};
  const auto n = twists(), m = static_cast<Index>(kBodyMeasures);
  const PoseFitOptions options;
  for (int i = 0; i < iterations; ++i) {
    const auto derivatives = measure_derivatives(fit.body);
    MatrixXd S = MatrixXd::Zero(m, m);
    VectorXd s = VectorXd::Zero(m);
    std::vector<MatrixXd> back(frames.size());
    std::vector<VectorXd> own(frames.size());
    for (std::size_t f = 0; f < frames.size(); ++f) {
      auto equations = empty_equations(n + m);
      add_silhouettes(equations, fit.body, fit.poses[f], frames[f], {}, &derivatives);
      auto priors = empty_equations(n);
      add_priors(priors, fit.body, fit.poses[f], options);
      MatrixXd P = equations.H.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
      P += MatrixXd(priors.H.selfadjointView<Eigen::Lower>());
      P.diagonal().array() += 1.0;
      const MatrixXd C = equations.H.bottomLeftCorner(m, n);  // measures by twists
      const Eigen::LDLT<MatrixXd> factor(P);
      own[f] = factor.solve(equations.g.head(n) + priors.g);
      back[f] = factor.solve(C.transpose());
      S += MatrixXd(equations.H.bottomRightCorner(m, m).selfadjointView<Eigen::Lower>()) - C * back[f];
      s += equations.g.tail(m) - C * own[f];
    }
    const double alike = kAlike * static_cast<double>(frames.size());
    S /= alike;
    s /= alike;
    add_measure_prior(S, s, fit.body.measures, measures_of_height(height_of(fit.body.measures)));
    const VectorXd step = -S.ldlt().solve(s);
    auto measures = fit.body.measures;
    for (std::size_t k = 0; k < kBodyMeasures; ++k) {
      const double most = 0.3 * measures[k];
      measures[k] += std::clamp(step[static_cast<Index>(k)], -most, most);
    }
    fit.body = make_template(measures);
    for (std::size_t f = 0; f < frames.size(); ++f)
      fit.poses[f] = moved(fit.poses[f], shortened(-own[f] - back[f] * step));
  }
  return fit;
}

}  // namespace rotunda::recon
