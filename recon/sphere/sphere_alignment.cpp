// Turning a whole sphere map: the rotation is free, so it is chosen by the body or by the previous frame.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <map>

#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {
namespace {

// The rotation R of greatest sum of w a . (R b), from the sum of w a b' (Horn 1987, here by SVD).
Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& correlation) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d mirror(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return svd.matrixU() * mirror.asDiagonal() * svd.matrixV().transpose();
}

SphereMap turned(const SphereMap& map, const Eigen::Matrix3d& rotation) {
  SphereMap result;
  result.points.reserve(map.points.size());
  for (const auto& point : map.points) result.points.push_back((rotation * point).normalized());
  return result;
}

// The surface in cubes of 5 cm: for each cube the sum of its triangles' directions, weighted by area.
using Cube = std::array<long, 3>;
std::map<Cube, Eigen::Vector3d> directions_by_place(const TriangleMesh& mesh, const SphereMap& map) {
  constexpr double kCube = 0.05;  // metres; limbs move by less between two frames at 25 Hz, mostly
  std::map<Cube, Eigen::Vector3d> directions;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                          c = mesh.positions[t[2]].cast<double>();
    const Eigen::Vector3d place = (a + b + c) / (3.0 * kCube);
    const Cube cube = {std::lround(place[0]), std::lround(place[1]), std::lround(place[2])};
    auto& sum = directions.try_emplace(cube, Eigen::Vector3d::Zero()).first->second;
    sum += (b - a).cross(c - a).norm() * (map.points[t[0]] + map.points[t[1]] + map.points[t[2]]);
  }
  return directions;
}

}  // namespace

SphereMap align_to_normals(const TriangleMesh& mesh, const SphereMap& map) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                          c = mesh.positions[t[2]].cast<double>();
    const Eigen::Vector3d direction = (map.points[t[0]] + map.points[t[1]] + map.points[t[2]]).normalized();
    correlation += (b - a).cross(c - a) * direction.transpose();
  }
  return turned(map, best_rotation(correlation));
}

SphereMap align_to(const TriangleMesh& mesh, const SphereMap& map, const TriangleMesh& previous_mesh,
                   const SphereMap& previous_map) {
  const auto before = directions_by_place(previous_mesh, previous_map);
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const auto& [cube, direction] : directions_by_place(mesh, map)) {
    const auto same_place = before.find(cube);
    if (same_place != before.end()) correlation += same_place->second.normalized() * direction.transpose();
  }
  if (correlation.isZero(0.0)) return map;  // the surfaces lie apart
  return turned(map, best_rotation(correlation));
}

}  // namespace rotunda::recon
