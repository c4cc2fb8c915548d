#include "recon/deform/scan_animation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <queue>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

std::array<int, kBodySegments> make_parents() {
  std::array<int, kBodySegments> parents;
  parents.fill(-1);
  for (std::size_t s = 0; s < kBodySegments; ++s)
    for (auto above = parent_of(joint_of_segment(s)); above && parents[s] < 0; above = parent_of(*above))
      for (std::size_t other = 0; other < kBodySegments; ++other)
        if (joint_of_segment(other) == *above) parents[s] = static_cast<int>(other);
  return parents;
}

// A marker as the prepared scan has it.
struct Placed {
  int number;
  std::uint32_t triangle, segment;
};

std::vector<Placed> place(const PreparedScan& scan, const Markers& markers, const TemplateFit& fit,
                          std::vector<std::string>& notes) {
  const auto posed = pose_template(fit.body, fit.pose);
  std::vector<std::string> problems;
  std::vector<Placed> placed;
  const std::uint32_t last = scan.from_triangle.empty() ? 0 : scan.from_triangle.back();
  for (const auto& marker : markers.pairs) {
    const auto at = std::lower_bound(scan.from_triangle.begin(), scan.from_triangle.end(), marker.scan_triangle);
    const auto segment = static_cast<std::uint32_t>(segment_of_triangle(marker.template_triangle));
    if (at == scan.from_triangle.end() || *at != marker.scan_triangle) {
      problems.push_back(fmt::format("marker {}: the scan has no triangle {} (its last is {})", marker.number,
                                     marker.scan_triangle, last));
      continue;
    }
    const auto triangle = static_cast<std::uint32_t>(at - scan.from_triangle.begin());
    if (const auto problem = misplacement(marker, scan.mesh, triangle, posed))
      problems.push_back(fmt::format("marker {}: {}", marker.number, *problem));
    placed.push_back({marker.number, triangle, segment});
  }
  if (!problems.empty()) {
    const std::size_t more = problems.size() - std::min<std::size_t>(problems.size(), 10);
    problems.resize(problems.size() - more);
    throw InvalidInput(fmt::format("the markers do not fit the scan:\n  {}{}", fmt::join(problems, "\n  "),
                                   more > 0 ? fmt::format("\n  and {} more", more) : ""));
  }
  std::vector<bool> has(kBodySegments, false);
  for (const auto& one : placed) has[one.segment] = true;
  for (std::size_t s = 0; s < kBodySegments; ++s)
    if (!has[s]) notes.push_back(fmt::format("no marker on {}: it follows its neighbours", segment_name(s)));
  if (!has[0]) throw InvalidInput("no marker on the pelvis: nothing would carry the scan along its path");
  return placed;
}

std::vector<std::vector<std::uint32_t>> neighbours_of(const TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) neighbours[t[k]].push_back(t[(k + 1) % 3]);
  return neighbours;
}

// Every vertex that a marked triangle has, and those that can be reached over the surface within `radius` of one; where
// segments meet, the nearer marker's. Pelvis first: as paper, the first is the one that is pinned.
std::vector<HeldVertex> held_by(const TriangleMesh& mesh, std::vector<Placed> placed, double radius) {
  std::stable_sort(placed.begin(), placed.end(),
                   [](const Placed& a, const Placed& b) { return a.segment < b.segment; });
  constexpr float kNowhere = std::numeric_limits<float>::max();
  std::vector<float> distance(mesh.positions.size(), kNowhere);
  std::vector<std::uint32_t> segment(mesh.positions.size(), 0);
  using Entry = std::pair<float, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const auto& one : placed)
    for (const auto v : mesh.triangles[one.triangle]) {
      if (distance[v] <= 0.0F) continue;
      distance[v] = 0.0F;
      segment[v] = one.segment;
      queue.emplace(0.0F, v);
    }
  const auto neighbours = neighbours_of(mesh);
  while (!queue.empty()) {
    const auto [reached, v] = queue.top();
    queue.pop();
    if (reached > distance[v]) continue;
    for (const auto to : neighbours[v]) {
      const float further = reached + (mesh.positions[to] - mesh.positions[v]).norm();
      if (further >= distance[to] || further > static_cast<float>(radius)) continue;
      distance[to] = further;
      segment[to] = segment[v];
      queue.emplace(further, to);
    }
  }
  std::vector<HeldVertex> held;
  for (std::uint32_t v = 0; v < distance.size(); ++v)
    if (distance[v] < kNowhere) held.push_back({v, segment[v]});
  std::stable_sort(held.begin(), held.end(), [](const auto& a, const auto& b) { return a.handle < b.handle; });
  return held;
}

std::vector<HandleJoint> joints_of(const TemplateFit& fit) {
  const auto positions = joint_positions(fit.body.skeleton, fit.pose);
  std::vector<HandleJoint> joints;
  for (std::uint32_t s = 0; s < kBodySegments; ++s)
    if (const int parent = segment_parents()[s]; parent >= 0)
      joints.push_back({s, static_cast<std::uint32_t>(parent), positions[index(joint_of_segment(s))].cast<float>()});
  return joints;
}

}  // namespace

std::span<const int> segment_parents() {
  static const auto parents = make_parents();
  return parents;
}

ScanAnimation::ScanAnimation(PreparedScan scan, const Markers& markers, const ScanAnimationOptions& options)
    : scan_(std::move(scan)), as_paper_(options.as_paper) {
  fit_ = markers.fit ? *markers.fit : fit_template(scan_.mesh);
  const auto placed = place(scan_, markers, fit_, notes_);
  held_ = held_by(scan_.mesh, placed, as_paper_ ? 0.0 : markers.radius);
  PoissonDeformOptions deform{
      .handles = kBodySegments, .hold_positions = !as_paper_, .joints = {}, .bridges = scan_.bridges};
  if (!as_paper_) deform.joints = joints_of(fit_);
  deform_ = std::make_unique<PoissonDeform>(scan_.mesh, held_, deform);
}

std::vector<HandlePose> ScanAnimation::handle_poses(const BodyMotion& motion) const {
  const auto& skeleton = fit_.body.skeleton;
  std::vector<HandlePose> poses;
  for (const auto& pose : poses_for(motion, skeleton)) carry_handles(joint_transforms(skeleton, pose), poses);
  if (!as_paper_) agree_in_sign(poses, segment_parents());
  return poses;
}

std::vector<HandlePose> ScanAnimation::handle_poses_in_studio(const CapturedMotion& motion) const {
  std::vector<HandlePose> poses;
  for (const auto& frame : motion.frames) carry_handles(joint_transforms(motion.body.skeleton, frame.fit.pose), poses);
  if (!as_paper_) agree_in_sign(poses, segment_parents());
  return poses;
}

// From where the scan's joints are to `posed`, a handle a segment.
void ScanAnimation::carry_handles(const JointTransforms& posed, std::vector<HandlePose>& poses) const {
  const auto at_scan = joint_transforms(fit_.body.skeleton, fit_.pose);
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    const auto joint = index(joint_of_segment(s));
    const Eigen::Isometry3d posed_from_scan = posed[joint] * at_scan[joint].inverse();
    Eigen::Quaterniond rotation(posed_from_scan.linear());
    if (rotation.w() < 0.0) rotation.coeffs() = -rotation.coeffs();
    poses.push_back({rotation.cast<float>(), posed_from_scan.translation().cast<float>()});
  }
}

double ScanAnimation::drift(std::span<const HandlePose> poses, std::span<const Vector3f> positions) const {
  float worst = 0.0F;
  const std::size_t vertices = scan_.mesh.positions.size();
  for (std::size_t f = 0; f < poses.size() / kBodySegments; ++f)
    for (const auto& held : held_) {
      const auto& pose = poses[f * kBodySegments + held.handle];
      const Vector3f wanted = pose.rotation * scan_.mesh.positions[held.vertex] + pose.translation;
      worst = std::max(worst, (positions[f * vertices + held.vertex] - wanted).norm());
    }
  return static_cast<double>(worst);
}

}  // namespace rotunda::recon
