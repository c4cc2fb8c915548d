#pragma once
// A booth scanner as there are real ones: four columns about the person, each with viewpoints one above the other; a
// point is measured by two neighbours of a column that both see it, not too much from the side (triangulation; Daanen
// and Ter Haar, "3D whole body scanners revisited", Displays 2013). So nothing is known of armpits, crotch, soles,
// crown and the shadow of the chin, and little of what is dark. World frame, metres, z up.
#include <array>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::simulator {

inline constexpr std::size_t kScannerColumns = 4;

// How one column sees one vertex.
struct Sighting {
  float cosine = 0.0F;                                 // between the normal and the way to the viewpoint
  Eigen::Vector3f towards = Eigen::Vector3f::UnitX();  // unit, from the vertex to the viewpoint
  bool measured = false;
};
using Sightings = std::vector<std::array<Sighting, kScannerColumns>>;  // one a vertex

// The booth stands about the middle of the surface. `seed`: of what is lost of dark places.
Sightings scanner_sightings(const recon::TriangleMesh& surface, std::uint32_t seed);

}  // namespace rotunda::simulator
