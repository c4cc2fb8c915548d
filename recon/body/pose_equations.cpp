#include "recon/body/pose_equations.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace rotunda::recon {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCut = 0.10;       // metres: what is farther apart is simply wrong
constexpr double kPartner = 0.04;   // metres: closer than this is explained
constexpr double kFarthest = 0.45;  // metres: nobody looks for a partner beyond
constexpr double kFacing = 0.3;     // least cosine between the normals of partners

std::vector<Twist> make_twists() {
  std::vector<Twist> twists;
  for (int axis = 0; axis < 3; ++axis)
    twists.push_back({BodyJoint::pelvis, Twist::Kind::translation, Vector3d::Unit(axis)});
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto joint = body_joint(j);
    const auto& range = range_of(joint);
    if (range.motion == JointMotion::free || range.motion == JointMotion::ball)
      for (int axis = 0; axis < 3; ++axis) twists.push_back({joint, Twist::Kind::own_axis, Vector3d::Unit(axis)});
    if (range.motion == JointMotion::hinge || range.motion == JointMotion::hinge_and_twist)
      twists.push_back({joint, Twist::Kind::parent_axis, range.hinge});
    if (range.motion == JointMotion::hinge_and_twist) twists.push_back({joint, Twist::Kind::own_axis, range.bone});
  }
  return twists;
}

std::array<std::vector<std::uint16_t>, kBodyJoints> make_chains() {
  std::array<std::vector<std::uint16_t>, kBodyJoints> chains;
  const auto& twists = pose_twists();
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    if (const auto parent = parent_of(body_joint(j))) chains[j] = chains[index(*parent)];
    for (std::size_t k = 0; k < twists.size(); ++k)
      if (index(twists[k].joint) == j) chains[j].push_back(static_cast<std::uint16_t>(k));
  }
  return chains;
}

// A pose with all that rows need of it.
struct PosedBody {
  JointTransforms transforms;
  PosedVertices vertices;
  std::vector<Vector3d> axes, origins;                                // of the twists, world
  std::vector<std::array<Vector3d, kBodyMeasures>> joint_by_measure;  // how joints move with measures
};

PosedBody posed(const BodyTemplate& body, const Pose& pose, const MeasureDerivatives* measures) {
  PosedBody p;
  p.transforms = joint_transforms(body.skeleton, pose);
  p.vertices = posed_vertices(body, p.transforms);
  for (const auto& twist : pose_twists()) {
    const auto& own = p.transforms[index(twist.joint)];
    const auto parent = parent_of(twist.joint);
    Matrix3d frame = Matrix3d::Identity();
    if (twist.kind == Twist::Kind::own_axis) frame = own.linear();
    if (twist.kind == Twist::Kind::parent_axis && parent) frame = p.transforms[index(*parent)].linear();
    p.axes.push_back(frame * twist.axis);
    p.origins.push_back(own.translation());
  }
  if (!measures) return p;
  p.joint_by_measure.resize(kBodyJoints);
  for (std::size_t m = 0; m < kBodyMeasures; ++m) {
    p.joint_by_measure[0][m].setZero();
    for (std::size_t j = 1; j < kBodyJoints; ++j) {
      const auto parent = index(*parent_of(body_joint(j)));
      p.joint_by_measure[j][m] = p.joint_by_measure[parent][m] + p.transforms[parent].linear() * measures->offset[m][j];
    }
  }
  return p;
}

// One view's points against each other.
class ViewTerm {
 public:
  ViewTerm(const PosedBody& body, const OutlineView& view, const SilhouetteTermOptions& options,
           const MeasureDerivatives* measures, NormalEquations* equations)
      : body_(body), view_(view), options_(options), measures_(measures), equations_(equations) {
    if (view.outline.is_empty()) return;
    rim_ = template_rim(body.vertices, view.camera, options.spacing_px);
    for (const auto& point : rim_) metres_a_pixel_.push_back(depth_of(point) / focal());
    rim_to_outline();
    outline_to_rim();
  }
  const OutlineAgreement& agreement() const { return agreement_; }

 private:
  double focal() const { return 0.5 * (view_.camera.K(0, 0) + view_.camera.K(1, 1)); }
  double depth_of(const RimPoint& point) const {
    return std::max(1e-3, view_.camera.R.row(2).dot(point.point) + view_.camera.t.z());
  }
  void rim_to_outline();
  void outline_to_rim();
  const RimPoint* partner_of(const OutlinePoint& point, std::size_t& which) const;
  void add_row(const RimPoint& point, const Vector2d& across, double residual, double metres_a_pixel);

  const PosedBody& body_;
  const OutlineView& view_;
  const SilhouetteTermOptions& options_;
  const MeasureDerivatives* measures_;
  NormalEquations* equations_;
  std::vector<RimPoint> rim_;
  std::vector<double> metres_a_pixel_;
  OutlineAgreement agreement_;
};

void ViewTerm::rim_to_outline() {
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    const auto& point = rim_[i];
    const auto sample = view_.outline.sample(point.pixel);
    if (!sample) continue;
    const double distance = -sample->distance_px * metres_a_pixel_[i];  // positive: the rim stands out
    const double norm = sample->gradient.norm();
    ++agreement_.rim_points;
    ++agreement_.segment_rim[point.segment];
    agreement_.sum += std::min(distance * distance, kCut * kCut);
    // Inside, near an outline that faces elsewhere: it is another limb's.
    const bool other = norm < 0.3 || -sample->gradient.dot(point.normal) < kFacing * norm;
    if (std::abs(distance) < kPartner && !other) {
      ++agreement_.on_outline;
      ++agreement_.segment_on_outline[point.segment];
    }
    if (norm < 0.3 || (other && distance < 0.0)) continue;
    add_row(point, -sample->gradient / norm, distance, metres_a_pixel_[i]);
  }
}

// The nearest rim point that faces the same way.
const RimPoint* ViewTerm::partner_of(const OutlinePoint& point, std::size_t& which) const {
  double best = std::numeric_limits<double>::infinity();
  const RimPoint* partner = nullptr;
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    const double away = (rim_[i].pixel - point.pixel).squaredNorm();
    if (away >= best) continue;
    const double facing = rim_[i].normal.dot(point.normal);
    if (facing < kFacing) continue;
    const double unlike = away * (1.0 + 2.0 * (1.0 - facing));
    if (unlike < best) {
      best = unlike;
      partner = &rim_[i];
      which = i;
    }
  }
  return partner;
}

void ViewTerm::outline_to_rim() {
  for (const auto& point : view_.outline.points) {
    std::size_t which = 0;
    const RimPoint* partner = partner_of(point, which);
    ++agreement_.outline_points;
    const double scale = partner ? metres_a_pixel_[which] : 0.0;
    const Vector2d way = partner ? Vector2d(partner->pixel - point.pixel) : Vector2d::Zero();
    const double apart = way.norm() * scale;
    if (!partner || apart > kFarthest) {
      agreement_.sum += kCut * kCut;
      continue;
    }
    const double distance = way.dot(point.normal) * scale;
    agreement_.sum += std::min(distance * distance, kCut * kCut);
    if (apart < kPartner) ++agreement_.explained;
    add_row(*partner, point.normal, distance, scale);
  }
}

void ViewTerm::add_row(const RimPoint& point, const Vector2d& across, double residual, double metres_a_pixel) {
  if (!equations_) return;
  const double ratio = residual / options_.robust_scale, robust = 1.0 / ((1.0 + ratio * ratio) * (1.0 + ratio * ratio));
  const double weight = robust / (options_.correlation * options_.sigma * options_.sigma);
  const Vector3d by_point =
      metres_a_pixel * (across.transpose() * pixel_jacobian(view_.camera, point.point)).transpose();
  const auto joint = joint_of_segment(point.segment);
  std::vector<std::uint16_t> columns = twists_of(joint);
  std::vector<double> values(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& twist = pose_twists()[columns[i]];
    const Vector3d& axis = body_.axes[columns[i]];
    values[i] = twist.kind == Twist::Kind::translation
                    ? by_point.dot(axis)
                    : by_point.dot(axis.cross(point.point - body_.origins[columns[i]]));
  }
  if (measures_)
    for (std::size_t m = 0; m < kBodyMeasures; ++m) {
      const Vector3d own =
          (1.0 - point.mix) * measures_->vertex[m][point.a] + point.mix * measures_->vertex[m][point.b];
      columns.push_back(static_cast<std::uint16_t>(pose_twists().size() + m));
      values.push_back(
          by_point.dot(body_.joint_by_measure[index(joint)][m] + body_.transforms[index(joint)].linear() * own));
    }
  equations_->add(columns, values.data(), residual, weight);
}

}  // namespace

const std::vector<Twist>& pose_twists() {
  static const auto twists = make_twists();
  return twists;
}

const std::vector<std::uint16_t>& twists_of(BodyJoint joint) {
  static const auto chains = make_chains();
  return chains[index(joint)];
}

Pose moved(const Pose& pose, const Eigen::VectorXd& step) {
  Pose result = pose;
  const auto& twists = pose_twists();
  std::array<Vector3d, kBodyJoints> own;
  own.fill(Vector3d::Zero());
  for (std::size_t k = 0; k < twists.size(); ++k) {
    const double amount = step[static_cast<Eigen::Index>(k)];
    const auto j = index(twists[k].joint);
    if (twists[k].kind == Twist::Kind::translation) result.root += amount * twists[k].axis;
    if (twists[k].kind == Twist::Kind::own_axis) own[j] += amount * twists[k].axis;
    if (twists[k].kind == Twist::Kind::parent_axis)
      result.rotation[j] = Quaterniond(Eigen::AngleAxisd(amount, twists[k].axis)) * result.rotation[j];
  }
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    if (const double angle = own[j].norm(); angle > 0.0)
      result.rotation[j] = (result.rotation[j] * Quaterniond(Eigen::AngleAxisd(angle, own[j] / angle))).normalized();
  return result;
}

MeasureDerivatives measure_derivatives(const BodyTemplate& body) {
  constexpr double kStep = 1e-5;  // metres; the template is linear in nearly all of its measures
  MeasureDerivatives derivatives;
  for (std::size_t m = 0; m < kBodyMeasures; ++m) {
    auto measures = body.measures;
    measures[m] += kStep;
    const auto other = make_template(measures);
    for (std::size_t j = 0; j < kBodyJoints; ++j)
      derivatives.offset[m][j] = (other.skeleton.offset[j] - body.skeleton.offset[j]) / kStep;
    for (std::size_t s = 0; s < kBodySegments; ++s)
      for (std::size_t v = 0; v < vertices_of_segment(); ++v)
        derivatives.vertex[m].push_back((other.segments[s].vertices[v] - body.segments[s].vertices[v]) / kStep);
  }
  return derivatives;
}

void NormalEquations::add(const std::vector<std::uint16_t>& columns, const double* values, double residual,
                          double weight) {
  cost += 0.5 * weight * residual * residual;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double weighted = weight * values[i];
    g[columns[i]] += weighted * residual;
    for (std::size_t k = 0; k <= i; ++k) H(columns[i], columns[k]) += weighted * values[k];  // columns ascend
  }
}

OutlineAgreement& OutlineAgreement::operator+=(const OutlineAgreement& other) {
  outline_points += other.outline_points;
  explained += other.explained;
  rim_points += other.rim_points;
  on_outline += other.on_outline;
  sum += other.sum;
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    segment_rim[s] += other.segment_rim[s];
    segment_on_outline[s] += other.segment_on_outline[s];
  }
  return *this;
}

double OutlineAgreement::rms() const {
  const auto points = outline_points + rim_points;
  return points == 0 ? kCut : std::sqrt(sum / static_cast<double>(points));
}

double OutlineAgreement::share() const {
  const auto points = outline_points + rim_points;
  return points == 0 ? 0.0 : static_cast<double>(explained + on_outline) / static_cast<double>(points);
}

OutlineAgreement add_silhouettes(NormalEquations& equations, const BodyTemplate& body, const Pose& pose,
                                 const FrameOutlines& frame, const SilhouetteTermOptions& options,
                                 const MeasureDerivatives* measures) {
  const auto p = posed(body, pose, measures);
  std::vector<NormalEquations> parts(frame.size());
  std::vector<OutlineAgreement> agreements(frame.size());
  tbb::parallel_for(std::size_t{0}, frame.size(), [&](std::size_t v) {
    parts[v].H.setZero(equations.H.rows(), equations.H.cols());
    parts[v].g.setZero(equations.g.size());
    agreements[v] = ViewTerm(p, frame[v], options, measures, &parts[v]).agreement();
  });
  OutlineAgreement total;
  for (std::size_t v = 0; v < frame.size(); ++v) {  // in order: the same sum on any number of threads
    equations.H += parts[v].H;
    equations.g += parts[v].g;
    equations.cost += parts[v].cost;
    total += agreements[v];
  }
  return total;
}

OutlineAgreement agreement(const BodyTemplate& body, const Pose& pose, const FrameOutlines& frame) {
  const auto p = posed(body, pose, nullptr);
  std::vector<OutlineAgreement> agreements(frame.size());
  tbb::parallel_for(std::size_t{0}, frame.size(),
                    [&](std::size_t v) { agreements[v] = ViewTerm(p, frame[v], {}, nullptr, nullptr).agreement(); });
  OutlineAgreement total;
  for (const auto& part : agreements) total += part;
  return total;
}

}  // namespace rotunda::recon
