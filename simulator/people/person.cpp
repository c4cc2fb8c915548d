#include "simulator/people/person.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "config/errors.h"
#include "simulator/people/body_mesh.h"
#include "simulator/people/skin_colour.h"

namespace rotunda::simulator {
namespace {

constexpr double kClothSpacing = 0.026;  // metres between particles

// A slim woman of 1.64 m with a ponytail.
PersonDescription anna() {
  PersonDescription anna{.name = "anna"};
  anna.build = {.height = 1.64,
                .girth = 0.95,
                .seed = 2,
                .sex = Sex::female,
                .proportions = {.shoulders = 0.90, .hips = 0.98, .arms = 0.985},
                .limbs = 0.93,
                .ease = 0.0,
                .hair = HairStyle::ponytail,
                .face = {.nose_width = 0.93, .lips = 1.05, .jaw = 0.97},
                .outfit = Outfit::close_fit};
  auto& look = anna.clothing;
  look.skin = {226, 180, 158}, look.hair = {128, 88, 50}, look.iris = {84, 112, 124}, look.lips = {190, 98, 96};
  look.shirt = {226, 186, 74}, look.shirt_check = {62, 50, 66}, look.shirt_line = {196, 60, 50};
  look.trousers = {58, 62, 78}, look.shoe = {206, 200, 192}, look.sole = {230, 226, 218};
  look.freckles = 0.22;
  return anna;
}

// A tall, broad man, dark skinned, bald and bearded.
PersonDescription bo() {
  PersonDescription bo{.name = "bo"};
  bo.build = {.height = 1.88,
              .girth = 1.03,
              .seed = 3,
              .proportions = {.shoulders = 1.06, .legs = 1.01},
              .waist = 1.03,
              .limbs = 1.08,
              .belly = 0.02,
              .ease = 0.6,
              .hair = HairStyle::bald,
              .face = {.nose_width = 1.22, .lips = 1.28, .jaw = 1.06, .brow = 1.05, .beard = 0.007}};
  auto& look = bo.clothing;
  look.skin = {122, 80, 58}, look.hair = {34, 26, 24}, look.iris = {52, 34, 24}, look.lips = {122, 70, 66};
  look.shirt = {196, 198, 190}, look.shirt_check = {104, 126, 110}, look.shirt_line = {170, 110, 76};
  look.trousers = {74, 66, 60}, look.shoe = {48, 40, 38}, look.sole = {34, 32, 32};
  look.stubble = 0.0, look.blush = 0.5, look.freckles = 0.0;
  return bo;
}

// A fuller woman of 1.70 m with a dark bob.
PersonDescription carla() {
  PersonDescription carla{.name = "carla"};
  carla.build = {.height = 1.70,
                 .girth = 1.07,
                 .seed = 4,
                 .sex = Sex::female,
                 .proportions = {.shoulders = 0.93, .hips = 1.04, .arms = 0.985},
                 .waist = 1.05,
                 .bust = 1.12,
                 .limbs = 1.06,
                 .belly = 0.012,
                 .ease = 0.0,
                 .hair = HairStyle::bob,
                 .face = {.nose_width = 1.04, .lips = 1.18, .jaw = 1.0, .brow = 1.15, .cheeks = 1.08},
                 .outfit = Outfit::dress};
  auto& look = carla.clothing;
  look.skin = {198, 146, 116}, look.hair = {40, 28, 24}, look.iris = {70, 46, 28}, look.lips = {172, 74, 76};
  look.shirt = {132, 40, 62}, look.shirt_check = {236, 206, 196}, look.shirt_line = {226, 140, 96};
  look.trousers = {60, 54, 58}, look.shoe = {52, 40, 40}, look.sole = {40, 34, 34};
  return carla;
}

// A lean older man of 1.80 m, grey.
PersonDescription dan() {
  PersonDescription dan{.name = "dan"};
  dan.build = {
      .height = 1.80,
      .girth = 0.97,
      .hair_volume = 0.75,
      .seed = 5,
      .proportions = {.shoulders = 1.0, .legs = 1.005},
      .limbs = 0.95,
      .belly = 0.025,
      .ease = 0.8,
      .face = {.nose_width = 1.05, .nose_length = 1.18, .lips = 0.8, .jaw = 0.96, .brow = 1.15, .cheeks = 0.95},
      .outfit = Outfit::coat};
  auto& look = dan.clothing;
  look.skin = {220, 172, 152}, look.hair = {150, 146, 142}, look.iris = {96, 120, 132}, look.lips = {180, 112, 106};
  look.shirt = {112, 122, 148}, look.shirt_check = {82, 92, 120}, look.shirt_line = {140, 150, 172};
  look.trousers = {70, 66, 62}, look.shoe = {58, 40, 30}, look.sole = {36, 32, 30};
  look.stubble = 0.30, look.blush = 1.0;
  return dan;
}

// To add a person: a row here.
std::vector<PersonDescription> descriptions() {
  return {{"alex", BodyBuild{}, Clothing{}}, anna(), bo(), carla(), dan()};
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

SurfaceMaterial material_at(const BodyShape& shape, const Eigen::Vector3d& p, const BodyPlace& place) {
  const bool tight = shape.build().outfit == Outfit::close_fit;
  if (place.worn.garment == Garment::trousers && tight) return SurfaceMaterial::denim;
  if (place.worn.garment == Garment::coat) return SurfaceMaterial::wool;
  if (place.worn.garment != Garment::bare) return SurfaceMaterial::cloth;
  if (place.material == Material::skin || place.material == Material::hair) return skin_material(shape, p, place);
  if (place.material == Material::shoe || place.material == Material::sole) return SurfaceMaterial::leather;
  return SurfaceMaterial::cloth;
}

std::vector<SurfaceMaterial> vertex_materials(const recon::TriangleMesh& mesh, const std::vector<std::size_t>& parts,
                                              const BodyShape& shape) {
  std::vector<SurfaceMaterial> materials(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, materials.size(), [&](std::size_t v) {
    const Eigen::Vector3d p = mesh.positions[v].cast<double>();
    materials[v] = material_at(shape, p, shape.place_on(parts[v], p));
  });
  return materials;
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
  person.skeleton = make_skeleton(description.build.height, description.build.proportions);
  const BodyShape shape(person.skeleton, description.build);
  person.bind = body_mesh(shape, person.skeleton, description.coarseness);
  const auto parts = vertex_parts(person.bind, shape);
  person.bind.colours = vertex_colours(person.bind, parts, shape, description.clothing);
  person.weights = skin_weights(person.bind, shape);
  person.openness = vertex_openness(person.bind, shape);
  person.material = vertex_materials(person.bind, parts, shape);
  person.texture = paint_surface(person.bind, description.texels_per_edge, [&](std::size_t triangle, const auto& p) {
    return colour_on(person.bind, parts, shape, description.clothing, triangle, p);
  });
  person.cloth = cloth_of(person.bind, shape, person.skeleton, kClothSpacing * std::max(1.0, description.coarseness));
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
