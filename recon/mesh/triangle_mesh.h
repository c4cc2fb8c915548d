#pragma once
// A triangle mesh as it is stored, drawn and handed from stage to stage. World frame, metres. Triangles are
// counter-clockwise seen from outside.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace rotunda::recon {

using Colour = std::array<std::uint8_t, 3>;  // sRGB, red first

struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  // unit; empty or one per position
  std::vector<Colour> colours;           // empty or one per position
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// What a mesh is as a surface; nothing is assumed of it.
struct MeshTopology {
  std::size_t components = 0;     // of the used vertices, joined by edges
  long euler_characteristic = 0;  // V - E + F over used vertices
  bool closed = false;            // every edge has exactly two triangles, used in opposite directions
  bool manifold = false;          // closed, and every vertex has a single fan of triangles
  bool is_sphere() const { return manifold && components == 1 && euler_characteristic == 2; }
};
MeshTopology topology_of(const TriangleMesh& mesh);

// Area-weighted vertex normals, unit length; (0, 0, 1) at a vertex without area.
void compute_normals(TriangleMesh& mesh);

double signed_volume(const TriangleMesh& mesh);  // m^3, positive if triangles face outwards
double surface_area(const TriangleMesh& mesh);   // m^2

}  // namespace rotunda::recon
