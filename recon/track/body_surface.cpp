#include "recon/track/body_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "config/errors.h"
#include "recon/hull/marching_cubes.h"
#include "recon/mesh/simplify.h"
#include "recon/mesh/smoothing.h"
#include "recon/track/nearest_on_triangle.h"

namespace rotunda::recon {
namespace {

constexpr double kRounding = 0.025;  // metres: where segments meet, over about a joint's radius
constexpr double kReach = 0.04;      // metres around a segment that its distance is known
constexpr float kOutside = -static_cast<float>(kReach);

struct Segment {
  std::vector<Eigen::Vector3d> points, normals;
  Eigen::AlignedBox3d box;
};

std::vector<Segment> segments_of(const BodyTemplate& body, const Pose& pose) {
  const auto mesh = pose_template(body, pose);
  std::vector<Segment> segments(kBodySegments);
  for (std::size_t s = 0; s < kBodySegments; ++s)
    for (std::size_t i = 0; i < vertices_of_segment(); ++i) {
      segments[s].points.push_back(mesh.positions[s * vertices_of_segment() + i].cast<double>());
      segments[s].normals.push_back(mesh.normals[s * vertices_of_segment() + i].cast<double>());
      segments[s].box.extend(segments[s].points.back());
    }
  return segments;
}

// Positive inside, metres.
double depth_in(const Segment& segment, const Eigen::Vector3d& point) {
  double nearest = std::numeric_limits<double>::infinity(), side = 1.0;
  for (const auto& t : segment_triangles()) {
    const Eigen::Vector3d &a = segment.points[t[0]], &b = segment.points[t[1]], &c = segment.points[t[2]];
    const Eigen::Vector3d at = nearest_barycentric(point, a, b, c);
    const Eigen::Vector3d way = at[0] * a + at[1] * b + at[2] * c - point;
    if (way.squaredNorm() >= nearest) continue;
    nearest = way.squaredNorm();
    side = way.dot(at[0] * segment.normals[t[0]] + at[1] * segment.normals[t[1]] + at[2] * segment.normals[t[2]]);
  }
  return std::copysign(std::sqrt(nearest), side);
}

// Rounded union of two depths.
double united(double a, double b) {
  const double near = std::max(kRounding - std::abs(a - b), 0.0) / kRounding;
  return std::max(a, b) + 0.25 * kRounding * near * near;
}

SignedGrid grid_around(const std::vector<Segment>& segments, double cell) {
  Eigen::AlignedBox3d box;
  for (const auto& segment : segments) box.extend(segment.box);
  const Eigen::Vector3d origin = box.min().array() - kReach;
  const Eigen::Vector3i blocks =
      ((box.sizes().array() + 2.0 * kReach) / (cell * SignedGrid::kSide)).ceil().cast<int>() + 1;
  std::vector<Eigen::Vector3i> all;
  for (int z = 0; z < blocks.z(); ++z)
    for (int y = 0; y < blocks.y(); ++y)
      for (int x = 0; x < blocks.x(); ++x) all.emplace_back(x, y, z);
  return {origin, cell, kOutside, all};
}

void fill(SignedGrid& grid, const std::vector<Segment>& segments) {
  tbb::parallel_for(std::size_t{0}, grid.block_count(), [&](std::size_t block) {
    for (int i = 0; i < SignedGrid::kBlockSize; ++i) {
      const auto id = static_cast<VoxelId>(block * SignedGrid::kBlockSize + static_cast<std::size_t>(i));
      const auto point = grid.position(id);
      double depth = kOutside;
      for (const auto& segment : segments)
        if (segment.box.exteriorDistance(point) < kReach) depth = united(depth, depth_in(segment, point));
      grid.set_value(id, static_cast<float>(depth));
    }
  });
}

}  // namespace

Pose free_pose() {
  constexpr double kDegrees = std::numbers::pi / 180.0;
  constexpr double kLegs = 15.0 * kDegrees, kArms = 35.0 * kDegrees;  // off the vertical; below the horizontal
  auto pose = rest_pose();
  const auto turn = [&](BodyJoint joint, double angle) {
    pose.rotation[index(joint)] = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX());
  };
  turn(BodyJoint::thigh_left, kLegs);
  turn(BodyJoint::thigh_right, -kLegs);
  turn(BodyJoint::upper_arm_left, -kArms);
  turn(BodyJoint::upper_arm_right, kArms);
  return pose;
}

TriangleMesh body_surface(const BodyTemplate& body, const Pose& pose, double cell) {
  const auto segments = segments_of(body, pose);
  auto grid = grid_around(segments, cell);
  fill(grid, segments);
  auto mesh = marching_cubes(grid);
  if (!topology_of(mesh).is_sphere())
    throw InvalidInput("a body whose measures no person has: its parts do not join to one closed surface");
  smooth(mesh, {.rounds = 5});
  collapse_slivers(mesh, 0.4 * cell);
  compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::recon
