#include "recon/sphere/resample.h"

#include <Eigen/Geometry>
#include <string>

#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {
namespace {

Eigen::Vector3d blend(const std::vector<Eigen::Vector3f>& values, const std::array<std::uint32_t, 3>& triangle,
                      const Eigen::Vector3d& barycentric) {
  return values[triangle[0]].cast<double>() * barycentric[0] + values[triangle[1]].cast<double>() * barycentric[1] +
         values[triangle[2]].cast<double>() * barycentric[2];
}

Eigen::Vector3f unit(const Eigen::Vector3d& normal, const Eigen::Vector3d& otherwise) {
  const double length = normal.norm();
  return (length > 1e-6 ? Eigen::Vector3d(normal / length) : otherwise).cast<float>();
}

Eigen::Vector3d face_normal(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                        c = mesh.positions[t[2]].cast<double>();
  const Eigen::Vector3d cross = (b - a).cross(c - a);
  return cross.norm() > 0.0 ? Eigen::Vector3d(cross.normalized()) : Eigen::Vector3d::UnitZ();
}

std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  if (mesh.normals.size() == mesh.positions.size()) return mesh.normals;
  TriangleMesh copy{.positions = mesh.positions, .normals = {}, .colours = {}, .triangles = mesh.triangles};
  compute_normals(copy);
  return copy.normals;
}

}  // namespace

std::vector<SurfaceSample> sample_lattice(const TriangleMesh& mesh, const SphereMap& map, int level) {
  if (map.points.size() != mesh.positions.size() || mesh.triangles.empty())
    throw InvalidInput("the sphere map has " + std::to_string(map.points.size()) + " points, the mesh " +
                       std::to_string(mesh.positions.size()) + " vertices: map this very mesh first");
  const auto directions = lattice_directions(level);
  const SphereLocator locator(mesh, map);
  const auto side = static_cast<std::size_t>(lattice_side(level));
  std::vector<SurfaceSample> samples(directions.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto from = canonical_sample(level, static_cast<int>(i % side), static_cast<int>(i / side));
    // The sample above is near on the sphere, and so is the one to the left.
    const auto near = i % side > 0 ? i - 1 : (i >= side ? i - side : 0);
    samples[i] = from == i ? locator.locate(directions[i], samples[near].triangle) : samples[from];
  }
  return samples;
}

SurfacePoints surface_points(const TriangleMesh& mesh, const SphereMap& map, int level) {
  const auto normals = vertex_normals(mesh);
  SurfacePoints points;
  for (const auto& sample : sample_lattice(mesh, map, level)) {
    const auto& triangle = mesh.triangles[sample.triangle];
    points.positions.push_back(blend(mesh.positions, triangle, sample.barycentric).cast<float>());
    points.normals.push_back(unit(blend(normals, triangle, sample.barycentric), face_normal(mesh, triangle)));
  }
  return points;
}

GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, int level) {
  auto points = surface_points(mesh, map, level);
  GeometryImage image;
  image.level = level;
  image.colour_level = level;
  image.positions = std::move(points.positions);
  image.normals = std::move(points.normals);
  return image;
}

TriangleMesh remesh(const GeometryImage& image) {
  if (image.positions.size() != lattice_size(image.level))
    throw InvalidInput("the geometry image has " + std::to_string(image.positions.size()) + " positions, not " +
                       std::to_string(lattice_size(image.level)));
  const auto lattice = weld_lattice(image.level);
  const bool has_normals = image.normals.size() == image.positions.size();
  const bool has_colours =
      image.colour_level >= image.level && image.colours.size() == lattice_size(image.colour_level);
  const auto side = static_cast<std::size_t>(image.side()), colour_side = static_cast<std::size_t>(image.colour_side());
  TriangleMesh mesh;
  mesh.triangles = lattice.triangles;
  for (const auto sample : lattice.sample_of_vertex) {
    mesh.positions.push_back(image.positions[sample]);
    if (has_normals) mesh.normals.push_back(image.normals[sample]);
    if (!has_colours) continue;
    const auto stride = (colour_side - 1) / (side - 1);
    mesh.colours.push_back(image.colours[(sample / side) * stride * colour_side + (sample % side) * stride]);
  }
  return mesh;
}

}  // namespace rotunda::recon
