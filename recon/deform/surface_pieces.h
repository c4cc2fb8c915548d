#pragma once
// The pieces a scan falls into (what the scanner did not see cuts hands and hems off), and what ties them together
// again without being seen.
#include <array>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct SurfacePieces {
  std::vector<std::uint32_t> piece;  // of each vertex: the number of its piece, the largest is 0
  std::vector<double> areas;         // of the pieces, falling
};
SurfacePieces pieces_of(const TriangleMesh& mesh);

// Triangles between vertices of different pieces, so that all hang together where they lie closest; `apart`: pieces
// farther than `reach` from all others (metres), which stay alone.
struct PieceBridges {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> apart;
  double widest = 0.0;  // metres, of the gaps bridged
};
PieceBridges bridge_pieces(const TriangleMesh& mesh, const SurfacePieces& pieces, double reach);

}  // namespace rotunda::recon
