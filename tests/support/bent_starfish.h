#pragma once
// A starfish whose limbs bend, as its geometry images, each mapped on its own: correspondence known by vertex number.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "recon/sphere/relaxed_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_map.h"
#include "recon/track/surface_target.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::tests {

// Limbs rise by `bend` metres at a metre from the centre; the whole is turned about z by `turn`.
inline recon::TriangleMesh bent_starfish(double bend, double turn = 0.0, int levels = 4) {
  auto mesh = starfish(levels);
  const Eigen::AngleAxisf about(static_cast<float>(turn), Eigen::Vector3f::UnitZ());
  for (auto& position : mesh.positions) {
    const float out = std::hypot(position.x(), position.y());
    position.z() += static_cast<float>(bend) * out * out;
    position = about * position;
  }
  recon::compute_normals(mesh);
  return mesh;
}

inline recon::GeometryImage image_of(const recon::TriangleMesh& mesh, const recon::SphereMap& map, int level) {
  auto image = recon::resample(mesh, map, level);
  image.colours.assign(image.positions.size(), {128, 128, 128});
  image.coverage.assign(image.positions.size(), 255);
  return image;
}

// How far the samples of two corresponding images lie from one point of the body, metres: the nearest point on the
// first's mesh, followed by vertex number to the second's.
inline std::vector<double> correspondence_errors(const recon::GeometryImage& a, const recon::TriangleMesh& mesh_a,
                                                 const recon::GeometryImage& b, const recon::TriangleMesh& mesh_b) {
  const recon::SurfaceTarget target(mesh_a);
  std::vector<double> errors;
  for (std::size_t i = 0; i < a.positions.size(); ++i) {
    const auto hit = target.closest(a.positions[i].cast<double>(), a.normals[i].cast<double>(), 0.2);
    if (!hit) continue;
    Eigen::Vector3d there = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      there += hit->sample.barycentric[k] *
               mesh_b.positions[mesh_b.triangles[hit->sample.triangle][static_cast<std::size_t>(k)]].cast<double>();
    errors.push_back((there - b.positions[i].cast<double>()).norm());
  }
  return errors;
}

inline double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

inline double share_within(const std::vector<double>& values, double limit) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), [&](double value) { return value < limit; })) /
         static_cast<double>(values.size());
}

}  // namespace rotunda::tests
