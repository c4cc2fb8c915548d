#include "recon/sphere/resample.h"

#include <Eigen/Geometry>
#include <string>

#include "config/errors.h"
#include "recon/sphere/lattice_fit.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/relaxed_lattice.h"

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

// How far a triangle leans away from the normals at its corners, times its area.
double lean(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Eigen::Vector3f cross =
      (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
  return static_cast<double>(3.0F * cross.norm() -
                             cross.dot(mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]]));
}

// Cuts the cells of a welded lattice (two triangles each, raster order) along their better diagonals. The two cells at
// the middle of each side are left: there the square folds, and their other diagonals would join the same two points.
void turn_diagonals(TriangleMesh& mesh, int level) {
  const std::size_t cells = std::size_t{1} << level;
  const auto outermost = [&](std::size_t i) { return i == 0 || i == cells - 1; };
  const auto middle = [&](std::size_t i) { return i == cells / 2 || i + 1 == cells / 2; };
  for (std::size_t cell = 0; cell < cells * cells; ++cell) {
    const auto x = cell % cells, y = cell / cells;
    if ((outermost(x) && middle(y)) || (outermost(y) && middle(x))) continue;
    auto &first = mesh.triangles[2 * cell], &second = mesh.triangles[2 * cell + 1];
    // (a, b, d), (b, c, d) or (a, b, c), (a, c, d): a is first's first, the one not in first is second's own.
    const bool along_bd = second[0] == first[1];
    const auto a = first[0], b = first[1], c = along_bd ? second[1] : first[2], d = along_bd ? first[2] : second[2];
    const double bd = lean(mesh, {a, b, d}) + lean(mesh, {b, c, d}), ac = lean(mesh, {a, b, c}) + lean(mesh, {a, c, d});
    if (along_bd == (bd <= ac)) continue;
    first = along_bd ? std::array{a, b, c} : std::array{a, b, d};
    second = along_bd ? std::array{a, c, d} : std::array{b, c, d};
  }
}

SurfacePoints points_under(const TriangleMesh& mesh, const std::vector<SurfaceSample>& samples) {
  const auto normals = vertex_normals(mesh);
  SurfacePoints points;
  for (const auto& sample : samples) {
    const auto& triangle = mesh.triangles[sample.triangle];
    points.positions.push_back(blend(mesh.positions, triangle, sample.barycentric).cast<float>());
    points.normals.push_back(unit(blend(normals, triangle, sample.barycentric), face_normal(mesh, triangle)));
  }
  return points;
}

}  // namespace

std::vector<SurfaceSample> sample_lattice(const TriangleMesh& mesh, const SphereMap& map,
                                          const std::vector<Eigen::Vector3d>& directions) {
  if (map.points.size() != mesh.positions.size() || mesh.triangles.empty())
    throw InvalidInput("the sphere map has " + std::to_string(map.points.size()) + " points, the mesh " +
                       std::to_string(mesh.positions.size()) + " vertices: map this very mesh first");
  const int level = lattice_level(directions.size());
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

SurfacePoints surface_points(const TriangleMesh& mesh, const SphereMap& map,
                             const std::vector<Eigen::Vector3d>& directions) {
  return points_under(mesh, sample_lattice(mesh, map, directions));
}

GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, const std::vector<Eigen::Vector3d>& directions) {
  const auto samples = sample_lattice(mesh, map, directions);
  auto points = points_under(mesh, samples);
  fit_positions(mesh, SphereLocator(mesh, map), directions, samples, points.normals, points.positions);
  GeometryImage image;
  image.level = image.colour_level = lattice_level(directions.size());
  image.positions = std::move(points.positions);
  image.normals = std::move(points.normals);
  return image;
}

GeometryImage resample(const TriangleMesh& mesh, const SphereMap& map, int level) {
  if (map.points.size() != mesh.positions.size() || mesh.triangles.empty())
    throw InvalidInput("the sphere map is not one of this mesh: map it first");
  return resample(mesh, map, relaxed_lattice(mesh, map, level));
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
  if (has_normals) turn_diagonals(mesh, image.level);
  return mesh;
}

}  // namespace rotunda::recon
