#include "recon/deform/template_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using enum BodyJoint;

struct Sample {
  Vector3d point, normal;
};

// Evenly over the surface: every so many square metres one, in the triangles' order.
std::vector<Sample> samples_of(const TriangleMesh& scan, std::size_t count) {
  const double step = surface_area(scan) / static_cast<double>(count);
  std::vector<Sample> samples;
  double passed = 0.5 * step;
  for (const auto& t : scan.triangles) {
    const Eigen::Vector3f& a = scan.positions[t[0]];
    passed += 0.5 * static_cast<double>((scan.positions[t[1]] - a).cross(scan.positions[t[2]] - a).norm());
    if (passed < step) continue;
    passed = std::fmod(passed, step);
    const Eigen::Vector3f normal = scan.normals[t[0]] + scan.normals[t[1]] + scan.normals[t[2]];
    samples.push_back({((a + scan.positions[t[1]] + scan.positions[t[2]]) / 3.0F).cast<double>(),
                       normal.cast<double>().normalized()});
  }
  return samples;
}

// What is solved for: logarithms of measures against those of the height, the root, rotation vectors of all joints
// against the pose begun with.
constexpr Eigen::Index kMeasureStart = 0, kRootStart = kBodyMeasures, kJointStart = kRootStart + 3,
                       kUnknowns = kJointStart + 3 * static_cast<Eigen::Index>(kBodyJoints);

struct Guess {
  BodyMeasures measures;
  Pose pose;
};

struct Body {
  BodyTemplate body;
  Pose pose;
  std::array<Eigen::Isometry3d, kBodyJoints> transforms;
  Vector3d vertex(std::size_t segment, std::size_t v) const {
    return transforms[index(joint_of_segment(segment))] * body.segments[segment].vertices[v];
  }
};

Quaterniond turn(const Vector3d& vector) {
  const double angle = vector.norm();
  return angle < 1e-12 ? Quaterniond::Identity() : Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Body body_at(const Guess& guess, const VectorXd& x) {
  BodyMeasures measures;
  for (std::size_t i = 0; i < kBodyMeasures; ++i)
    measures[i] = guess.measures[i] * std::exp(x[kMeasureStart + static_cast<Eigen::Index>(i)]);
  Body at{.body = make_template(measures), .pose = guess.pose, .transforms = {}};
  at.pose.root += x.segment<3>(kRootStart);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const Vector3d vector = x.segment<3>(kJointStart + 3 * static_cast<Eigen::Index>(j));
    at.pose.rotation[j] = guess.pose.rotation[j] * turn(vector);
  }
  at.transforms = joint_transforms(at.body.skeleton, at.pose);
  return at;
}

// How far a person is from the mean at a height (ANSUR II: lengths vary by 3 to 5 %, widths by 8 to 15 %; clothes and
// hair add), and from the pose first guessed, radians.
VectorXd deviations() {
  VectorXd s(kUnknowns);
  for (std::size_t i = 0; i < kBodyMeasures; ++i)
    s[static_cast<Eigen::Index>(i)] = i <= index(BodyMeasure::foot_height) ? 0.035 : 0.15;
  s.segment<3>(kRootStart).setConstant(0.05);
  const auto set = [&](BodyJoint joint, double x, double y, double z) {
    s.segment<3>(kJointStart + 3 * static_cast<Eigen::Index>(index(joint))) = Vector3d(x, y, z);
    s.segment<3>(kJointStart + 3 * static_cast<Eigen::Index>(index(mirrored(joint)))) = Vector3d(x, y, z);
  };
  set(pelvis, 0.05, 0.1, 0.1);
  set(spine, 0.05, 0.1, 0.05);
  set(chest, 0.05, 0.1, 0.05);
  set(neck, 0.05, 0.2, 0.05);
  set(head, 0.01, 0.01, 0.01);
  set(clavicle_left, 0.1, 0.01, 0.1);
  set(upper_arm_left, 0.3, 0.05, 0.3);
  set(forearm_left, 0.02, 0.05, 0.3);
  set(hand_left, 0.2, 0.1, 0.2);
  set(thigh_left, 0.2, 0.2, 0.05);
  set(shank_left, 0.02, 0.2, 0.02);
  set(foot_left, 0.1, 0.2, 0.2);
  return s;
}

Vector3d mean_of(const std::vector<Sample>& samples, const auto& wanted, const Vector3d& otherwise) {
  Vector3d sum = Vector3d::Zero();
  double count = 0.0;
  for (const auto& sample : samples)
    if (wanted(sample.point)) {
      sum += sample.point;
      ++count;
    }
  return count > 0.0 ? Vector3d(sum / count) : otherwise;
}

// An adult of the scan's height whose hips, ankles and fingertips lie where the scan's do.
Guess first_guess(const std::vector<Sample>& samples) {
  Eigen::AlignedBox3d box;
  for (const auto& sample : samples) box.extend(sample.point);
  const double floor = box.min().z(), height = box.sizes().z();
  const auto level = [&](const Vector3d& p) { return (p.z() - floor) / height; };
  Guess guess{.measures = measures_of_height(height), .pose = rest_pose()};
  const auto measure = [&](BodyMeasure m) -> double& { return guess.measures[index(m)]; };
  const double y = box.center().y();
  const Vector3d middle = mean_of(
      samples,
      [&](const Vector3d& p) { return std::abs(level(p) - 0.55) < 0.05 && std::abs(p.y() - y) < 0.11 * height; },
      box.center());
  const double hips =
      floor + measure(BodyMeasure::foot_height) + measure(BodyMeasure::shank) + measure(BodyMeasure::thigh);
  guess.pose.root = {middle.x(), middle.y(), hips};
  const auto skeleton = make_template(guess.measures).skeleton;
  const auto at_rest = joint_positions(skeleton, guess.pose);
  double reach = 0.0;
  for (const bool right : {false, true}) {
    const double side = right ? -1.0 : 1.0;
    const auto at = [&](BodyJoint left) { return index(right ? mirrored(left) : left); };
    const auto tip = std::max_element(samples.begin(), samples.end(), [&](const Sample& a, const Sample& b) {
      return side * a.point.y() < side * b.point.y();
    });
    const Vector3d arm = tip->point - at_rest[at(upper_arm_left)];
    reach += 0.5 * arm.norm();
    guess.pose.rotation[at(upper_arm_left)] = Quaterniond::FromTwoVectors(Vector3d(0, side, 0), arm);
    const Vector3d hip = at_rest[at(thigh_left)];
    const Vector3d ankle = mean_of(
        samples,
        [&](const Vector3d& p) { return std::abs(level(p) - 0.08) < 0.03 && side * (p.y() - middle.y()) > 0.0; },
        hip - Vector3d(0, 0, hips - floor));
    guess.pose.rotation[at(thigh_left)] = Quaterniond::FromTwoVectors(-Vector3d::UnitZ(), ankle - hip);
    guess.pose.rotation[at(foot_left)] = guess.pose.rotation[at(thigh_left)].conjugate();
  }
  const double arm = measure(BodyMeasure::upper_arm) + measure(BodyMeasure::forearm) + measure(BodyMeasure::hand);
  for (const auto m : {BodyMeasure::upper_arm, BodyMeasure::forearm, BodyMeasure::hand})
    measure(m) *= std::clamp(reach / arm, 0.8, 1.25);
  return guess;
}

// A point of the template (segment, vertex) and where on which plane it should lie.
struct Match {
  std::size_t segment, vertex;
  Vector3d point, normal;
};

struct Surface {
  std::vector<Vector3d> points, normals;
  std::vector<bool> inside;  // another segment: no scanner sees it
};

Surface surface_at(const Body& at) {
  const auto mesh = pose_template(at.body, at.pose);
  Surface surface;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    surface.points.push_back(mesh.positions[i].cast<double>());
    surface.normals.push_back(mesh.normals[i].cast<double>());
  }
  const std::size_t n = vertices_of_segment();
  surface.inside.assign(surface.points.size(), false);
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    for (std::size_t s = 0; s < kBodySegments && !surface.inside[i]; ++s) {
      if (s == i / n) continue;
      std::size_t nearest = s * n;
      for (std::size_t k = s * n; k < (s + 1) * n; ++k)
        if ((surface.points[k] - surface.points[i]).squaredNorm() <
            (surface.points[nearest] - surface.points[i]).squaredNorm())
          nearest = k;
      surface.inside[i] = (surface.points[i] - surface.points[nearest]).dot(surface.normals[nearest]) < -0.004;
    }
  return surface;
}

constexpr double kAgree = 0.4;  // cosine between normals

std::vector<Match> find_matches(const std::vector<Sample>& samples, const Surface& surface, double reach) {
  std::vector<Match> matches;
  const std::size_t n = vertices_of_segment();
  std::vector<double> nearest_of(surface.points.size(), reach * reach);
  std::vector<std::size_t> sample_of(surface.points.size(), samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double nearest = reach * reach;
    std::size_t found = surface.points.size();
    for (std::size_t k = 0; k < surface.points.size(); ++k) {
      const double distance = (surface.points[k] - samples[i].point).squaredNorm();
      if (distance >= nearest && distance >= nearest_of[k]) continue;
      if (surface.inside[k] || surface.normals[k].dot(samples[i].normal) < kAgree) continue;
      if (distance < nearest_of[k]) {
        nearest_of[k] = distance;
        sample_of[k] = i;
      }
      if (distance >= nearest) continue;
      nearest = distance;
      found = k;
    }
    if (found < surface.points.size())
      matches.push_back({found / n, found % n, samples[i].point, surface.normals[found]});
  }
  for (std::size_t k = 0; k < surface.points.size(); ++k)
    if (sample_of[k] < samples.size())
      matches.push_back({k / n, k % n, samples[sample_of[k]].point, samples[sample_of[k]].normal});
  return matches;
}

VectorXd residuals(const Body& at, const std::vector<Match>& matches) {
  VectorXd r(static_cast<Eigen::Index>(matches.size()));
  for (std::size_t i = 0; i < matches.size(); ++i)
    r[static_cast<Eigen::Index>(i)] =
        matches[i].normal.dot(at.vertex(matches[i].segment, matches[i].vertex) - matches[i].point);
  return r;
}

// One Gauss-Newton step with fixed matches, prior and Huber's weights.
void step(const Guess& guess, const std::vector<Match>& matches, const VectorXd& prior, VectorXd& x) {
  constexpr double kDelta = 1e-5, kHuber = 0.015, kNoise = 0.01, kIndependent = 150.0;
  const VectorXd r = residuals(body_at(guess, x), matches);
  MatrixXd jacobian(r.size(), kUnknowns);
  for (Eigen::Index u = 0; u < kUnknowns; ++u) {
    VectorXd moved = x;
    moved[u] += kDelta;
    jacobian.col(u) = (residuals(body_at(guess, moved), matches) - r) / kDelta;
  }
  // Neighbouring matches err alike: all together they count as so many independent ones.
  const double scale = kIndependent / static_cast<double>(r.size()) / (kNoise * kNoise);
  const VectorXd weight =
      scale * r.unaryExpr([](double d) { return std::abs(d) < kHuber ? 1.0 : kHuber / std::abs(d); });
  MatrixXd normal = jacobian.transpose() * weight.asDiagonal() * jacobian;
  const VectorXd inverse = prior.cwiseAbs2().cwiseInverse();
  normal.diagonal() += inverse;
  const VectorXd gradient = jacobian.transpose() * (weight.asDiagonal() * r) + inverse.cwiseProduct(x);
  x -= normal.ldlt().solve(gradient);
}

void judge(const std::vector<Sample>& samples, TemplateFit& fit) {
  const auto surface = surface_at({fit.body, fit.pose, joint_transforms(fit.body.skeleton, fit.pose)});
  std::vector<double> distances;
  for (const auto& match : find_matches(samples, surface, 0.05))
    distances.push_back(
        std::abs(match.normal.dot(surface.points[match.segment * vertices_of_segment() + match.vertex] - match.point)));
  std::size_t far = 0;
  for (const auto& sample : samples) far += find_matches({sample}, surface, 0.05).empty() ? 1U : 0U;
  fit.far_share = static_cast<double>(far) / static_cast<double>(samples.size());
  if (distances.empty()) return;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  fit.distance = *middle;
}

}  // namespace

TemplateFit fit_template(const TriangleMesh& scan) {
  if (scan.triangles.empty() || scan.normals.size() != scan.positions.size())
    throw InvalidInput("a scan to fit needs triangles and normals");
  const auto samples = samples_of(scan, 3000);
  const auto guess = first_guess(samples);
  const auto prior = deviations();
  VectorXd x = VectorXd::Zero(kUnknowns);
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    const double reach = std::max(0.05, 0.15 - 0.007 * round);
    const auto matches = find_matches(samples, surface_at(body_at(guess, x)), reach);
    if (matches.empty()) break;
    step(guess, matches, prior, x);
  }
  const auto found = body_at(guess, x);
  TemplateFit fit{.body = found.body, .pose = found.pose};
  judge(samples, fit);
  return fit;
}

}  // namespace rotunda::recon
