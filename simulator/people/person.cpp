#include "simulator/people/person.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "config/errors.h"
#include "simulator/people/body_mesh.h"

namespace rotunda::simulator {
namespace {

// To add a person: a row here.
std::vector<PersonDescription> descriptions() {
  return {{"alex", BodyBuild{}, Clothing{}}};
}

std::vector<std::size_t> vertex_parts(const recon::TriangleMesh& mesh, const BodyShape& shape) {
  std::vector<std::size_t> parts(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, parts.size(),
                    [&](std::size_t v) { parts[v] = shape.nearest_part(mesh.positions[v].cast<double>()); });
  return parts;
}

// The search for the nearest part is most of the cost of a colour; where a triangle's corners agree it is known.
Eigen::Vector3d colour_on(const recon::TriangleMesh& mesh, const std::vector<std::size_t>& parts,
                          const BodyShape& shape, const Clothing& wear, std::size_t triangle,
                          const Eigen::Vector3d& p) {
  const auto& t = mesh.triangles[triangle];
  const bool known = parts[t[0]] == parts[t[1]] && parts[t[1]] == parts[t[2]];
  return colour_at(shape, wear, p, known ? shape.place_on(parts[t[0]], p) : shape.place_of(p));
}

std::vector<recon::Colour> vertex_colours(const recon::TriangleMesh& mesh, const std::vector<std::size_t>& parts,
                                          const BodyShape& shape, const Clothing& wear) {
  std::vector<recon::Colour> colours(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, colours.size(), [&](std::size_t v) {
    const Eigen::Vector3d p = mesh.positions[v].cast<double>();
    const Eigen::Vector3d c = 255.0 * colour_at(shape, wear, p, shape.place_on(parts[v], p));
    for (std::size_t i = 0; i < 3; ++i)
      colours[v][i] = static_cast<std::uint8_t>(c[static_cast<Eigen::Index>(i)] + 0.5);
  });
  return colours;
}

std::vector<float> vertex_openness(const recon::TriangleMesh& mesh, const BodyShape& shape) {
  std::vector<float> openness(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, openness.size(), [&](std::size_t v) {
    openness[v] = static_cast<float>(shape.openness(mesh.positions[v].cast<double>(), mesh.normals[v].cast<double>()));
  });
  return openness;
}

}  // namespace

Person make_person(const PersonDescription& description) {
  Person person;
  person.name = description.name;
  person.skeleton = make_skeleton(description.build.height);
  const BodyShape shape(person.skeleton, description.build);
  person.bind = body_mesh(shape, person.skeleton, description.coarseness);
  const auto parts = vertex_parts(person.bind, shape);
  person.bind.colours = vertex_colours(person.bind, parts, shape, description.clothing);
  person.weights = skin_weights(person.bind, shape);
  person.openness = vertex_openness(person.bind, shape);
  person.texture = paint_surface(person.bind, description.texels_per_edge, [&](std::size_t triangle, const auto& p) {
    return colour_on(person.bind, parts, shape, description.clothing, triangle, p);
  });
  return person;
}

Person make_person(std::string_view name) {
  return make_person(describe_person(name));
}

PersonDescription describe_person(std::string_view name) {
  for (const auto& description : descriptions())
    if (description.name == name) return description;
  throw InvalidInput(
      fmt::format("there is no person '{}'; the simulator knows: {}", name, fmt::join(person_names(), ", ")));
}

std::vector<std::string> person_names() {
  std::vector<std::string> names;
  for (const auto& description : descriptions()) names.push_back(description.name);
  return names;
}

recon::TriangleMesh posed_mesh(const Person& person, const Pose& pose) {
  return skinned(person.bind, person.weights, joint_transforms(person.skeleton, pose));
}

}  // namespace rotunda::simulator
