#pragma once
// Clips of the simulator's people whose samples correspond perfectly: the bind surface is mapped to the sphere once and
// read at every moment. What motion graphs are tried on where reconstruction and matching must not blur the answer.
#include <stdexcept>
#include <string>
#include <vector>

#include "recon/sphere/geometry_image.h"
#include "recon/sphere/relaxed_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_map.h"
#include "simulator/people/performance.h"

namespace rotunda::tests {

struct TruthLattice {
  recon::SphereMap map;
  std::vector<Eigen::Vector3d> directions;
  int level = 6;
};

inline TruthLattice truth_lattice(const simulator::Performance& performance, int level) {
  const auto& bind = performance.figures().front().bind;
  auto mapped = recon::map_to_sphere(bind);
  if (!mapped.map) throw std::runtime_error("the bind surface has no sphere map: " + mapped.report.failure);
  auto directions = recon::relaxed_lattice(bind, *mapped.map, level);
  return {std::move(*mapped.map), std::move(directions), level};
}

inline std::vector<recon::Colour> colours_at(const recon::TriangleMesh& mesh,
                                             const std::vector<recon::SurfaceSample>& samples) {
  std::vector<recon::Colour> colours(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0.5;
      for (int corner = 0; corner < 3; ++corner)
        sum += samples[i].barycentric[corner] *
               mesh.colours[mesh.triangles[samples[i].triangle][static_cast<std::size_t>(corner)]][c];
      colours[i][c] = static_cast<std::uint8_t>(sum);
    }
  return colours;
}

// Frames first to end - 1 of the act, 25 a second; the act starts again after its last.
inline std::vector<recon::GeometryImage> truth_clip(const simulator::Performance& performance,
                                                    const TruthLattice& lattice, int first, int end) {
  std::vector<recon::GeometryImage> images;
  const auto samples = recon::sample_lattice(performance.figures().front().bind, lattice.map, lattice.directions);
  for (int frame = first; frame < end; ++frame) {
    const auto mesh = performance.surfaces_at(simulator::act_seconds(frame % performance.frames())).front();
    recon::GeometryImage image;
    image.level = image.colour_level = lattice.level;
    for (const auto& sample : samples) {
      const auto& corners = mesh.triangles[sample.triangle];
      Eigen::Vector3d position = Eigen::Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c)
        position += sample.barycentric[static_cast<int>(c)] * mesh.positions[corners[c]].cast<double>();
      image.positions.push_back(position.cast<float>());
    }
    image.colours = colours_at(mesh, samples);
    image.coverage.assign(image.colours.size(), 255);
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace rotunda::tests
