#include "recon/deform/markers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Where along its bone, from the segment's joint as a share of the bone's length, a segment is rigid enough to be held:
// about the joints the surface must be free to follow.
struct Held {
  double from, to;
};
Held held_part(std::size_t segment) {
  switch (joint_of_segment(segment)) {
    case BodyJoint::pelvis:
      return {-0.1, 0.7};
    case BodyJoint::spine:
      return {0.3, 0.7};
    case BodyJoint::chest:
      return {0.3, 0.9};
    case BodyJoint::neck:
      return {1.0, 3.5};  // the head above the neck
    case BodyJoint::hand_left:
    case BodyJoint::hand_right:
      return {0.3, 1.1};
    case BodyJoint::foot_left:
    case BodyJoint::foot_right:
      return {-0.5, 1.1};
    default:
      return {0.3, 0.7};
  }
}

Vector3d bone_of(const Skeleton& skeleton, std::size_t segment) {
  const auto joint = joint_of_segment(segment);
  switch (joint) {
    case BodyJoint::hand_left:
      return skeleton.fingertip;
    case BodyJoint::hand_right:
      return skeleton.fingertip.cwiseProduct(Vector3d(1, -1, 1));
    case BodyJoint::foot_left:
    case BodyJoint::foot_right:
      return {skeleton.toe.x(), 0.0, 0.0};
    default:
      return skeleton.offset[index(joint) + 1];  // limbs and spine are numbered from the trunk outwards
  }
}

// Nearest triangle of a surface with a normal like the one asked for, in a grid of cells.
class TriangleLocator {
 public:
  TriangleLocator(const TriangleMesh& mesh, double cell) : mesh_(mesh), cell_(cell) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) cells_[cell_of(middle(t))].push_back(t);
  }
  std::optional<std::uint32_t> nearest(const Vector3d& point, const Vector3d& normal) const {
    constexpr double kAgree = 0.4;
    std::optional<std::uint32_t> found;
    double least = cell_ * cell_;
    const auto centre = cell_of(point);
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto cell = cells_.find({centre[0] + dx, centre[1] + dy, centre[2] + dz});
          if (cell == cells_.end()) continue;
          for (const auto t : cell->second) {
            const double distance = (middle(t) - point).squaredNorm();
            if (distance >= least || normal_of(t).dot(normal) < kAgree) continue;
            least = distance;
            found = t;
          }
        }
    return found;
  }
  Vector3d middle(std::uint32_t t) const { return middle_of(mesh_, t).cast<double>(); }

 private:
  using Cell = std::array<int, 3>;
  Cell cell_of(const Vector3d& p) const {
    return {static_cast<int>(std::floor(p.x() / cell_)), static_cast<int>(std::floor(p.y() / cell_)),
            static_cast<int>(std::floor(p.z() / cell_))};
  }
  Vector3d normal_of(std::uint32_t t) const {
    const auto& c = mesh_.triangles[t];
    const Vector3f sum = mesh_.normals[c[0]] + mesh_.normals[c[1]] + mesh_.normals[c[2]];
    return sum.cast<double>().normalized();
  }

  const TriangleMesh& mesh_;
  double cell_;
  std::map<Cell, std::vector<std::uint32_t>> cells_;
};

bool is_held_part(const TemplateFit& fit, std::size_t segment, const std::array<std::uint32_t, 3>& corners) {
  Vector3d middle = Vector3d::Zero();
  for (const auto v : corners) middle += fit.body.segments[segment].vertices[v] / 3.0;
  const Vector3d bone = bone_of(fit.body.skeleton, segment);
  const double share = middle.dot(bone) / bone.squaredNorm();
  const auto part = held_part(segment);
  return share >= part.from && share <= part.to;
}

// As many as a person can oversee, and close enough that what lies between them is held, too.
bool is_crowded(const std::vector<Vector3d>& chosen, const Vector3d& point) {
  constexpr double kApart = 0.03;
  return std::any_of(chosen.begin(), chosen.end(),
                     [&](const Vector3d& other) { return (other - point).norm() < kApart; });
}

}  // namespace

std::size_t segment_of_triangle(std::uint32_t template_triangle) {
  return template_triangle / segment_triangles().size();
}

std::string_view segment_name(std::size_t segment) {
  return to_string(joint_of_segment(segment));
}

std::vector<MarkerConflict> MarkerRules::admit(const Marker& marker) {
  std::vector<MarkerConflict> conflicts;
  if (!numbers_.insert(marker.number).second) conflicts.push_back({"number", "a number that no other marker has"});
  const std::size_t own = segment_of_triangle(marker.template_triangle);
  const auto [first, added] = segment_on_scan_.try_emplace(marker.scan_triangle, own);
  if (!added && first->second != own)
    conflicts.push_back({"scan", fmt::format("a triangle that no other segment has; the {} has it already",
                                             segment_name(first->second))});
  return conflicts;
}

std::optional<std::string> misplacement(const Marker& marker, const TriangleMesh& scan, std::uint32_t triangle,
                                        const TriangleMesh& posed) {
  // A wrong pair is an arm for a leg or left for right, not a thick sleeve.
  constexpr float kFar = 0.30F;
  const float away = (middle_of(scan, triangle) - middle_of(posed, marker.template_triangle)).norm();
  if (away <= kFar) return std::nullopt;
  return fmt::format(
      "triangle {} lies {:.2f} m away from the {} it is paired with: left for right, or another scan's "
      "markers?",
      marker.scan_triangle, away, segment_name(segment_of_triangle(marker.template_triangle)));
}

Markers propose_markers(const TriangleMesh& scan, const std::vector<std::uint32_t>& number, const TemplateFit& fit) {
  constexpr double kReach = 0.05;
  const TriangleLocator locator(scan, kReach);
  const auto posed = pose_template(fit.body, fit.pose);
  const std::size_t of_segment = segment_triangles().size();
  Markers markers;
  markers.fit = fit;
  std::vector<Vector3d> chosen;
  for (std::uint32_t t = 0; t < posed.triangles.size(); ++t) {
    const std::size_t segment = t / of_segment;
    if (!is_held_part(fit, segment, segment_triangles()[t % of_segment])) continue;
    const auto& c = posed.triangles[t];
    const Vector3f middle = middle_of(posed, t);
    const Vector3f normal = (posed.normals[c[0]] + posed.normals[c[1]] + posed.normals[c[2]]).normalized();
    const auto found = locator.nearest(middle.cast<double>(), normal.cast<double>());
    if (!found || is_crowded(chosen, locator.middle(*found))) continue;
    chosen.push_back(locator.middle(*found));
    markers.pairs.push_back({static_cast<int>(markers.pairs.size()) + 1, t, number[*found]});
  }
  return markers;
}

}  // namespace rotunda::recon
