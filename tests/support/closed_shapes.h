#pragma once
// Small closed surfaces of known shape for tests. Metres, triangles counter-clockwise from outside.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::tests {

// The unit sphere as an icosahedron divided `levels` times: 10 * 4^levels + 2 vertices.
inline recon::TriangleMesh icosphere(int levels) {
  const float g = std::numbers::phi_v<float>;
  recon::TriangleMesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, added] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
      if (added) mesh.positions.push_back(0.5F * (mesh.positions[a] + mesh.positions[b]));
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& position : mesh.positions) position.normalize();
  return mesh;
}

// A body of 0.25 m with five thin bent limbs of 1 m: an icosphere drawn out, so its limbs are long stretched triangles.
inline recon::TriangleMesh starfish(int levels) {
  auto mesh = icosphere(levels);
  for (auto& position : mesh.positions) {
    double radius = 0.25;
    for (int limb = 0; limb < 5; ++limb) {
      const double turn = 2.0 * std::numbers::pi * limb / 5.0;
      const Eigen::Vector3d axis(std::cos(turn), std::sin(turn), 0.2 * limb - 0.4);
      const double angle = std::acos(std::min(1.0, position.cast<double>().dot(axis.normalized())));
      radius += std::exp(-angle * angle / 0.02);
    }
    position *= static_cast<float>(radius);
    position.z() += 0.5F * position.x() * position.x();
  }
  return mesh;
}

// Ring radius 1, tube radius 0.3: genus 1.
inline recon::TriangleMesh torus(std::uint32_t around = 24, std::uint32_t across = 12) {
  recon::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around, v = 2.0 * std::numbers::pi * j / across;
      const double r = 1.0 + 0.3 * std::cos(v);
      mesh.positions.emplace_back(Eigen::Vector3d(r * std::cos(u), r * std::sin(u), 0.3 * std::sin(v)).cast<float>());
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return (a % around) * across + b % across; };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

}  // namespace rotunda::tests
