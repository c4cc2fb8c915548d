#include "simulator/people/body_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "simulator/people/graded_lattice.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kBodyCell = 0.0165;    // metres, of a body of 1.75 m
constexpr double kHangingCell = 1.07;   // as many triangles again go into a skirt or coat
constexpr double kFingerCell = 0.0045;  // fingers stand 5 mm apart, so this one is no coarser for a coarser body

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
  return {{ankle.x() - 0.055 * h, ankle.y() - 0.042 * h, -0.01},
          {ankle.x() + 0.135 * h, ankle.y() + 0.042 * h, 0.06 * h},
          2};
}

GradedLatticeOptions lattice_for(const Skeleton& skeleton, double hanging, double coarseness) {
  const double h = skeleton.height;
  const double reach = skeleton.joint[index(Joint::hand_left)].y() + 0.11 * h;
  GradedLatticeOptions lattice{.low = {-std::max(0.14 * h, hanging), -reach, -0.03},
                               .high = {std::max(0.16 * h, hanging), reach, 1.03 * h},
                               .cell = kBodyCell * coarseness * h / 1.75 * (hanging > 0.0 ? kHangingCell : 1.0)};
  const Vector3d head = skeleton.joint[index(Joint::head)];
  lattice.finer.push_back({head + h * Vector3d(-0.075, -0.058, -0.030), head + h * Vector3d(0.085, 0.058, 0.135), 3});
  for (const Side side : {Side::left, Side::right}) {
    lattice.finer.push_back(hand_box(skeleton, side, lattice.cell));
    lattice.finer.push_back(foot_box(skeleton, side));
  }
  return lattice;
}

Vector3d onto_surface(const BodyShape& shape, Vector3d p) {
  for (int step = 0; step < 2; ++step) {
    const Vector3d g = shape.gradient(p);
    const double slope = std::max(g.norm(), 0.3);
    p -= g / slope * std::clamp(shape.distance(p) / slope, -0.006, 0.006);
  }
  return p;
}

// Evens the triangles out along the surface, then draws the vertices onto it.
void relax(const BodyShape& shape, recon::TriangleMesh& mesh,
           const std::vector<std::vector<std::uint32_t>>& neighbours) {
  const auto before = mesh.positions;
  tbb::parallel_for(std::size_t{0}, before.size(), [&](std::size_t v) {
    Vector3d mean = Vector3d::Zero();
    for (const auto n : neighbours[v]) mean += before[n].cast<double>();
    mean /= static_cast<double>(neighbours[v].size());
    const Vector3d here = before[v].cast<double>();
    mesh.positions[v] = onto_surface(shape, here + 0.5 * (mean - here)).cast<float>();
  });
}

}  // namespace

std::vector<std::vector<std::uint32_t>> neighbours_of(const recon::TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) neighbours[t[i]].push_back(t[(i + 1) % 3]);
  return neighbours;
}

recon::TriangleMesh body_mesh(const BodyShape& shape, const Skeleton& skeleton, double coarseness) {
  constexpr int kTries = 4;
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
  for (int round = 0; round < 3; ++round) relax(shape, mesh, neighbours);
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
