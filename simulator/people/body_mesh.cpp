#include "simulator/people/body_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "simulator/people/graded_lattice.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using Neighbours = std::vector<std::vector<std::uint32_t>>;

constexpr double kBodyCell = 0.0171;    // metres, of a body of 1.75 m
constexpr double kHangingCell = 1.07;   // as many triangles again go into a skirt or coat
constexpr double kFingerCell = 0.0048;  // fingers stand 5 mm apart, so this one is no coarser for a coarser body

// About the hand, from the wrist on.
FinerBox hand_box(const Skeleton& skeleton, Side side, double cell) {
  const double scale = skeleton.height / 1.75;
  const auto at = [&](Joint left) { return skeleton.joint[index(on_side(left, side))]; };
  const Vector3d wrist = at(Joint::hand_left), out = (wrist - at(Joint::forearm_left)).normalized();
  const Vector3d tips = wrist + 0.21 * scale * out, room = scale * Vector3d(0.075, 0.035, 0.035);
  const Vector3d start = wrist + 0.035 * scale * out;
  return {start.cwiseMin(tips) - room, start.cwiseMax(tips) + room, static_cast<int>(std::ceil(cell / kFingerCell))};
}

FinerBox foot_box(const Skeleton& skeleton, Side side) {
  const double h = skeleton.height;
  const Vector3d ankle = skeleton.joint[index(on_side(Joint::foot_left, side))];
  return {{ankle.x() - 0.055 * h, ankle.y() - 0.042 * h, -0.03},
          {ankle.x() + 0.135 * h, ankle.y() + 0.042 * h, 0.078 * h},  // above hem and shoe
          2};
}

GradedLatticeOptions lattice_for(const Skeleton& skeleton, double hanging, double coarseness) {
  const double h = skeleton.height;
  const double reach = skeleton.joint[index(Joint::hand_left)].y() + 0.11 * h;
  GradedLatticeOptions lattice{.low = {-std::max(0.14 * h, hanging), -reach, -0.05},
                               .high = {std::max(0.16 * h, hanging), reach, 1.03 * h},
                               .cell = kBodyCell * coarseness * h / 1.75 * (hanging > 0.0 ? kHangingCell : 1.0)};
  const Vector3d head = skeleton.joint[index(Joint::head)];
  lattice.finer.push_back({head + h * Vector3d(-0.075, -0.062, -0.080), head + h * Vector3d(0.085, 0.062, 0.135), 3});
  for (const Side side : {Side::left, Side::right}) {
    lattice.finer.push_back(hand_box(skeleton, side, lattice.cell));
    lattice.finer.push_back(foot_box(skeleton, side));
  }
  return lattice;
}

// A point of the surface and what it faces.
struct TangentPlane {
  Vector3d point, normal;
};

TangentPlane onto_surface(const BodyShape& shape, Vector3d p) {
  Vector3d normal = Vector3d::UnitZ();
  for (int step = 0; step < 2; ++step) {
    const Vector3d gradient = shape.gradient(p);
    const double slope = std::max(gradient.norm(), 0.3);
    normal = gradient / slope;
    p -= normal * std::clamp(shape.distance(p) / slope, -0.006, 0.006);
  }
  return {p, normal.normalized()};
}

// Evens the triangles out along the surface, then draws the vertices onto it.
void relax(const BodyShape& shape, recon::TriangleMesh& mesh, const Neighbours& neighbours) {
  const auto before = mesh.positions;
  tbb::parallel_for(std::size_t{0}, before.size(), [&](std::size_t v) {
    Vector3d mean = Vector3d::Zero();
    for (const auto n : neighbours[v]) mean += before[n].cast<double>();
    mean /= static_cast<double>(neighbours[v].size());
    const Vector3d here = before[v].cast<double>();
    const auto [point, normal] = onto_surface(shape, here + 0.5 * (mean - here));
    mesh.positions[v] = point.cast<float>();
    mesh.normals[v] = normal.cast<float>();
  });
}

// Vertices about which the surface turns sharply: hems, soles, lids.
std::vector<std::uint8_t> near_creases(const recon::TriangleMesh& mesh, const Neighbours& neighbours) {
  constexpr float kCosine = 0.80F;
  std::vector<std::uint8_t> near(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t v) {
    for (const auto n : neighbours[v])
      if (mesh.normals[v].dot(mesh.normals[n]) < kCosine) near[v] = 1;
  });
  return near;
}

// The point with the least squared distance from all planes; along the directions in which they say nothing, their
// middle.
Vector3d where_planes_meet(const std::vector<TangentPlane>& planes) {
  constexpr double kLeastEigenvalue = 0.10;  // against the largest
  Vector3d middle = Vector3d::Zero(), right = Vector3d::Zero();
  for (const auto& plane : planes) middle += plane.point / static_cast<double>(planes.size());
  Eigen::Matrix3d quadric = Eigen::Matrix3d::Zero();
  for (const auto& [point, normal] : planes) {
    quadric += normal * normal.transpose();
    right += normal * normal.dot(point - middle);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(quadric);
  Vector3d shift = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    if (eigen.eigenvalues()[i] > kLeastEigenvalue * eigen.eigenvalues()[2])
      shift += eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(right) / eigen.eigenvalues()[i]);
  return middle + shift;
}

Vector3d facing(const recon::TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t, std::uint32_t moved,
                const Vector3d& to) {
  std::array<Vector3d, 3> p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = t[i] == moved ? to : mesh.positions[t[i]].cast<double>();
  return (p[1] - p[0]).cross(p[2] - p[0]);
}

// Vertices at a crease move onto it, to where the tangent planes under the triangles about them meet (Ohtake and
// Belyaev, "Dual/primal mesh optimization for polygonized implicit surfaces", 2002): else a hem has teeth.
void sharpen(const BodyShape& shape, recon::TriangleMesh& mesh, const Neighbours& neighbours,
             const Neighbours& triangles_about) {
  const auto near = near_creases(mesh, neighbours);
  std::vector<TangentPlane> planes(mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, planes.size(), [&](std::size_t i) {
    const auto& t = mesh.triangles[i];
    if (!near[t[0]] && !near[t[1]] && !near[t[2]]) return;
    const Eigen::Vector3f middle = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3.0F;
    planes[i] = onto_surface(shape, middle.cast<double>());
  });
  const recon::TriangleMesh before = mesh;
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t v) {
    if (!near[v]) return;
    std::vector<TangentPlane> about;
    for (const auto t : triangles_about[v]) about.push_back(planes[t]);
    const auto vertex = static_cast<std::uint32_t>(v);
    const Vector3d here = before.positions[v].cast<double>(), target = where_planes_meet(about);
    double reach = 0.0;
    for (const auto n : neighbours[v])
      reach += 0.5 * (before.positions[n] - before.positions[v]).norm() / static_cast<double>(neighbours[v].size());
    const double way = (target - here).norm();
    const Vector3d to = here + (target - here) * std::min(1.0, reach / std::max(way, 1e-9));
    for (const auto t : triangles_about[v])  // none may turn over
      if (facing(before, before.triangles[t], vertex, to).dot(facing(before, before.triangles[t], vertex, here)) < 0.0)
        return;
    mesh.positions[v] = to.cast<float>();
  });
}

Neighbours triangles_by_vertex(const recon::TriangleMesh& mesh) {
  Neighbours triangles(mesh.positions.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for (const auto v : mesh.triangles[i]) triangles[v].push_back(i);
  return triangles;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> neighbours_of(const recon::TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) neighbours[t[i]].push_back(t[(i + 1) % 3]);
  return neighbours;
}

recon::TriangleMesh body_mesh(const BodyShape& shape, const Skeleton& skeleton, double coarseness) {
  constexpr int kTries = 6;
  recon::TriangleMesh mesh;
  recon::MeshTopology topology;
  for (int i = 0; i < kTries && !topology.is_sphere(); ++i) {  // a lattice may happen to fall badly on a narrow gap
    mesh = contour([&](const Vector3d& p) { return shape.distance(p); },
                   lattice_for(skeleton, shape.reach(), coarseness * (1.0 - 0.03 * i)));
    topology = recon::topology_of(mesh);
  }
  if (!topology.is_sphere())
    throw InvalidInput(
        fmt::format("this build gives a body of {} pieces with Euler characteristic {}, not one closed "
                    "surface; choose milder proportions",
                    topology.components, topology.euler_characteristic));
  const auto neighbours = neighbours_of(mesh);
  const auto triangles_about = triangles_by_vertex(mesh);
  mesh.normals.resize(mesh.positions.size());
  for (int round = 0; round < 2; ++round) relax(shape, mesh, neighbours);
  for (int round = 0; round < 2; ++round) sharpen(shape, mesh, neighbours, triangles_about);
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
