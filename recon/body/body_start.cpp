#include "recon/body/body_start.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kCell = 0.04;                     // metres
constexpr double kReach = 1.4;                     // metres around the middle of the silhouettes
constexpr double kFits = 0.70, kFitsWell = 0.80;   // of the outlines, explained
constexpr double kSameHeight = 0.04;               // share by which heights differ that frames tell of one person
constexpr double kShortest = 0.8, kTallest = 2.4;  // of people, metres, arms up

// The point nearest to the rays through the middles of the silhouettes.
std::optional<Vector3d> middle_of(const FrameOutlines& frame) {
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  int rays = 0;
  for (const auto& [camera, outline] : frame) {
    if (outline.is_empty()) continue;
    const Eigen::Vector2d pixel(outline.box.x + 0.5 * outline.box.width, outline.box.y + 0.5 * outline.box.height);
    const auto ray = capture::ray_through(camera, pixel);
    if (!ray) continue;
    const Matrix3d across = Matrix3d::Identity() - *ray * ray->transpose();
    A += across;
    b += across * camera.centre();
    ++rays;
  }
  if (rays < 2) return std::nullopt;
  return Vector3d(A.ldlt().solve(b));
}

bool is_occupied(const FrameOutlines& frame, const Vector3d& point) {
  int seen = 0;
  for (const auto& [camera, outline] : frame) {
    if (outline.is_empty()) continue;
    const auto pixel = capture::project(camera, point);
    if (!pixel) continue;
    const auto sample = outline.sample(*pixel);
    if (!sample) continue;
    if (sample->distance_px < 0.0) return false;
    ++seen;
  }
  return seen >= 2;
}

std::vector<Vector3d> occupied_points(const FrameOutlines& frame, const Vector3d& middle) {
  const auto steps = static_cast<std::size_t>(2.0 * kReach / kCell);
  std::vector<std::vector<Vector3d>> slices(steps);
  tbb::parallel_for(std::size_t{0}, steps, [&](std::size_t k) {
    for (std::size_t j = 0; j < steps; ++j)
      for (std::size_t i = 0; i < steps; ++i) {
        const Vector3d point = middle - Vector3d::Constant(kReach) +
                               kCell * Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        if (is_occupied(frame, point)) slices[k].push_back(point);
      }
  });
  std::vector<Vector3d> points;
  for (const auto& slice : slices) points.insert(points.end(), slice.begin(), slice.end());
  return points;
}

Quaterniond about(const Vector3d& axis, double degrees) {
  return Quaterniond(AngleAxisd(degrees * std::numbers::pi / 180.0, axis));
}

Pose standing_pose(const Vector3d& root, double yaw_deg, double arms_down_deg) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  auto pose = rest_pose();
  pose.root = root;
  const auto put = [&](BodyJoint joint, const Quaterniond& rotation) { pose.rotation[index(joint)] = rotation; };
  put(BodyJoint::pelvis, about(z, yaw_deg));
  put(BodyJoint::upper_arm_left, about(x, -arms_down_deg));
  put(BodyJoint::upper_arm_right, about(x, arms_down_deg));
  put(BodyJoint::forearm_left, about(z, -15));
  put(BodyJoint::forearm_right, about(z, 15));
  for (const auto thigh : {BodyJoint::thigh_left, BodyJoint::thigh_right}) put(thigh, about(y, -5));
  for (const auto shank : {BodyJoint::shank_left, BodyJoint::shank_right}) put(shank, about(y, 10));
  return pose;
}

std::vector<PoseFit> fits_from(const BodyTemplate& body, const FrameOutlines& frame, const std::vector<Pose>& poses,
                               const PoseFitOptions& options) {
  std::vector<PoseFit> fits;
  for (const auto& pose : poses) fits.push_back(fit_pose(body, frame, pose, options));
  std::sort(fits.begin(), fits.end(), [](const PoseFit& a, const PoseFit& b) { return a.residual < b.residual; });
  return fits;
}

}  // namespace

bool fits_well(const BodyStart& start) {
  return start.fit.explained >= kFitsWell;
}

std::optional<std::size_t> most_credible(const std::vector<BodyStart>& starts) {
  const bool any_well = std::any_of(starts.begin(), starts.end(), fits_well);
  std::vector<double> heights;
  const auto fits = [&](const BodyStart& one) { return any_well ? fits_well(one) : one.fit.explained >= kFits; };
  for (const auto& one : starts)
    if (fits(one)) heights.push_back(height_of(one.body.measures));
  if (heights.empty()) return std::nullopt;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const bool agrees = std::abs(height_of(starts[i].body.measures) - *middle) <= kSameHeight * *middle;
    if (!fits(starts[i]) || !agrees) continue;
    if (!best || starts[i].fit.residual < starts[*best].fit.residual) best = i;
  }
  return best;
}

bool BodyExtent::is_upright() const {
  constexpr double kLean = 25.0 * std::numbers::pi / 180.0;
  const double share = (centre.z() - floor) / height;
  return lean < kLean && height > kShortest && height < kTallest && share > 0.42 && share < 0.72;
}

std::optional<BodyExtent> body_extent(const FrameOutlines& frame) {
  const auto middle = middle_of(frame);
  if (!middle) return std::nullopt;
  const auto points = occupied_points(frame, *middle);
  if (points.size() < 100) return std::nullopt;
  BodyExtent extent{.centre = Vector3d::Zero(), .floor = points.front().z()};
  double top = extent.floor;
  for (const auto& point : points) {
    extent.centre += point / static_cast<double>(points.size());
    extent.floor = std::min(extent.floor, point.z());
    top = std::max(top, point.z());
  }
  extent.floor -= 0.5 * kCell;
  extent.height = top + 0.5 * kCell - extent.floor;
  Matrix3d spread = Matrix3d::Zero();
  for (const auto& point : points) spread += (point - extent.centre) * (point - extent.centre).transpose();
  const Vector3d axis = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors().col(2);
  extent.lean = std::acos(std::clamp(std::abs(axis.z()), 0.0, 1.0));
  return extent;
}

std::vector<Pose> standing_poses(const BodyTemplate& body, const BodyExtent& extent) {
  const Vector3d root(extent.centre.x(), extent.centre.y(), extent.floor + root_height_of(body.measures));
  std::vector<Pose> poses;
  for (int turn = 0; turn < 8; ++turn)
    for (const double down : {70.0, 10.0}) poses.push_back(standing_pose(root, 45.0 * turn, down));
  return poses;
}

std::optional<BodyStart> start_body(const FrameOutlines& frame, const std::optional<BodyTemplate>& known) {
  const auto extent = body_extent(frame);
  if (!extent || !extent->is_upright()) return std::nullopt;
  BodyStart start{known ? *known : template_of_height(extent->height), {}};
  auto tries = fits_from(start.body, frame, standing_poses(start.body, *extent),
                         {.iterations = 10, .first_scale = 0.30, .last_scale = 0.08, .spacing_px = 12.0});
  tries.resize(4);
  std::vector<Pose> poses;
  for (const auto& fit : tries) poses.push_back(fit.pose);
  if (known) {
    start.fit = fits_from(start.body, frame, poses, {.iterations = 15}).front();
    return start;
  }
  std::optional<BodyStart> best;
  for (const auto& pose : poses) {  // each with the measures that suit it, for feet and elbows tell front from back
    const auto solved = fit_body(start.body, {&frame, 1}, {&pose, 1}, 6);
    auto fit = fit_pose(solved.body, frame, solved.poses.front(), {.iterations = 12});
    if (!best || fit.residual < best->fit.residual) best = BodyStart{solved.body, std::move(fit)};
  }
  return best;
}

}  // namespace rotunda::recon
