#include "recon/sphere/spherical_matching.h"

#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "recon/sphere/matching_level.h"
#include "recon/sphere/matching_rotation.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/sphere_locator.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

void check(const GeometryImage& image) {
  check_lattice_level(image.level);
  if (image.positions.size() != lattice_size(image.level) || image.normals.size() != image.positions.size() ||
      image.colour_level < image.level || image.colours.size() != lattice_size(image.colour_level))
    throw InvalidInput("a geometry image to match has no normals or no colours, or fewer samples than its levels say");
}

std::size_t folds_of(const std::vector<Eigen::Vector3d>& directions, int level) {
  const auto triangles = lattice_triangles(level);
  return static_cast<std::size_t>(std::count_if(triangles.begin(), triangles.end(), [&](const auto& t) {
    return orientation(directions[t[0]], directions[t[1]], directions[t[2]]) <= 0;
  }));
}

// The deformed lattice as a mesh and its sphere map, to find places on it.
struct DeformedLattice {
  DeformedLattice(const std::vector<Eigen::Vector3d>& directions, int level) : lattice(weld_lattice(level)) {
    mesh.triangles = lattice.triangles;
    mesh.positions.resize(lattice.sample_of_vertex.size());
    for (const auto sample : lattice.sample_of_vertex) map.points.push_back(directions[sample]);
  }
  WeldedLattice lattice;
  TriangleMesh mesh;
  SphereMap map;
};

// For every sample of the undeformed lattice, where the deformed one shows it; calls `use(sample, corners, shares)`,
// corners as samples.
template <class Use>
void for_each_place(const std::vector<Eigen::Vector3d>& deformed, int level, const Use& use) {
  const DeformedLattice on(deformed, level);
  const SphereLocator locator(on.mesh, on.map);
  const auto directions = lattice_directions(level);
  std::uint32_t near = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto found = locator.locate(directions[i], near);
    near = found.triangle;
    const auto& t = on.mesh.triangles[found.triangle];
    const auto& sample_of = on.lattice.sample_of_vertex;
    use(i, std::array{sample_of[t[0]], sample_of[t[1]], sample_of[t[2]]}, found.barycentric);
  }
}

template <class Value>
Eigen::Vector3d blended(const std::vector<Value>& values, const std::array<std::uint32_t, 3>& corners,
                        const Eigen::Vector3d& shares) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& value = values[corners[k]];
    sum += shares[static_cast<Eigen::Index>(k)] *
           Eigen::Vector3d(static_cast<double>(value[0]), static_cast<double>(value[1]), static_cast<double>(value[2]));
  }
  return sum;
}

void read_colours(const GeometryImage& from, const std::vector<Eigen::Vector3d>& deformed, GeometryImage& image) {
  image.colours.resize(from.colours.size());
  image.coverage.resize(from.coverage.size());
  for_each_place(deformed, from.colour_level, [&](std::size_t i, const auto& corners, const auto& shares) {
    const auto colour = blended(from.colours, corners, shares);
    for (Eigen::Index c = 0; c < 3; ++c)
      image.colours[i][static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(colour[c]));
    if (image.coverage.empty()) return;
    Eigen::Index most = 0;
    shares.maxCoeff(&most);
    image.coverage[i] = from.coverage[corners[static_cast<std::size_t>(most)]];
  });
}

}  // namespace

SphereMatch match_on_sphere(const GeometryImage& from, const GeometryImage& to, const MatchingOptions& options) {
  check(from);
  check(to);
  if (from.level != to.level) throw InvalidInput("two geometry images to match are of unlike levels");
  SphereMatch match{.rotation = least_cost_rotation(from, to, options)};
  const auto from_middle = middle_of(from), to_middle = middle_of(to);
  for (auto& direction : match.directions = lattice_directions(kMinLatticeLevel))
    direction = (match.rotation * direction).normalized();
  for (int level = kMinLatticeLevel; level <= from.level; ++level) {
    if (level > kMinLatticeLevel) match.directions = refine_directions(match.directions, level);
    MatchingLevel at(level, lattice_features(from, level, from_middle, options),
                     lattice_features(to, level, to_middle, options), match.directions, options);
    match.levels.push_back(at.run());
    match.directions = at.directions();
  }
  match.folds = folds_of(match.directions, from.level);
  return match;
}

GeometryImage matched_image(const GeometryImage& from, const SphereMatch& match) {
  check(from);
  if (match.directions.size() != from.positions.size())
    throw InvalidInput("this match is not of a geometry image of this level");
  GeometryImage image{.level = from.level, .colour_level = from.colour_level};
  image.positions.resize(from.positions.size());
  image.normals.resize(from.normals.size());
  for_each_place(match.directions, from.level, [&](std::size_t i, const auto& corners, const auto& shares) {
    image.positions[i] = blended(from.positions, corners, shares).template cast<float>();
    image.normals[i] = blended(from.normals, corners, shares).normalized().template cast<float>();
  });
  auto finer = match.directions;
  for (int level = from.level + 1; level <= from.colour_level; ++level) finer = refine_directions(finer, level);
  read_colours(from, finer, image);
  return image;
}

}  // namespace rotunda::recon
