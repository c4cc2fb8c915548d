#pragma once
// A ball (or ellipsoid) as a geometry image in closed form, for tests of what stores and draws geometry images.
#include <cmath>
#include <cstdlib>

#include "recon/sphere/geometry_image.h"
#include "recon/video/lattice_normals.h"

namespace rotunda::test {

struct RoundOptions {
  int level = 5, colour_level = 6;
  Eigen::Vector3f centre{0.3F, -0.2F, 1.0F};  // world, metres
  Eigen::Vector3f radii{0.5F, 0.5F, 0.5F};    // metres
};

// Unit vector of the square's point (u, v) in [-1, 1]^2, unfolded octahedron: the pole +z at the centre, x with u.
inline Eigen::Vector3f octahedral_direction(float u, float v) {
  Eigen::Vector3f p(u, v, 1.0F - std::abs(u) - std::abs(v));
  if (p.z() < 0.0F) {
    p.x() = std::copysign(1.0F - std::abs(v), u);
    p.y() = std::copysign(1.0F - std::abs(u), v);
  }
  return p.normalized();
}

// Colour tells the place: red, green, blue are x, y, z of the direction.
inline recon::Colour direction_colour(const Eigen::Vector3f& direction) {
  recon::Colour colour{};
  for (int i = 0; i < 3; ++i)
    colour[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(127.5F + 127.5F * direction[i]));
  return colour;
}

inline recon::GeometryImage round_geometry_image(const RoundOptions& options = {}) {
  recon::GeometryImage image;
  image.level = options.level;
  image.colour_level = options.colour_level;
  const auto direction = [](int row, int column, int side) {
    const float last = static_cast<float>(side - 1);
    return octahedral_direction(2.0F * static_cast<float>(column) / last - 1.0F,
                                2.0F * static_cast<float>(row) / last - 1.0F);
  };
  for (int row = 0; row < image.side(); ++row)
    for (int column = 0; column < image.side(); ++column)
      image.positions.push_back(options.centre + options.radii.cwiseProduct(direction(row, column, image.side())));
  for (int row = 0; row < image.colour_side(); ++row)
    for (int column = 0; column < image.colour_side(); ++column)
      image.colours.push_back(direction_colour(direction(row, column, image.colour_side())));
  image.coverage.assign(image.colours.size(), 255);
  image.coverage.front() = 0;
  image.normals = recon::lattice_normals(image.positions, image.level);
  return image;
}

}  // namespace rotunda::test
