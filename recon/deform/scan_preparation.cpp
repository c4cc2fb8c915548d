#include "recon/deform/scan_preparation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "config/errors.h"
#include "recon/body/length_unit.h"
#include "recon/deform/surface_pieces.h"
#include "recon/deform/upright_stance.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

void check(const TriangleMesh& scan) {
  if (scan.triangles.empty()) throw InvalidInput("the scan has no triangles: a cloud of points must be meshed first");
  for (const auto& p : scan.positions)
    if (!p.allFinite()) throw InvalidInput("the scan has vertices that are nowhere (not a number, or infinite)");
  for (const auto& t : scan.triangles)
    for (const auto v : t)
      if (v >= scan.positions.size())
        throw InvalidInput(fmt::format("a triangle of the scan names vertex {} of {}", v, scan.positions.size()));
}

struct SamePlace {
  std::size_t operator()(const Vector3f& p) const {
    std::size_t hash = 0;
    for (int i = 0; i < 3; ++i) hash = hash * 1'000'003 + std::hash<float>()(p[i]);
    return hash;
  }
};

// The first vertex in the same place, for each.
std::vector<std::uint32_t> welded(const TriangleMesh& scan) {
  std::unordered_map<Vector3f, std::uint32_t, SamePlace> first;
  first.reserve(scan.positions.size());
  std::vector<std::uint32_t> vertex(scan.positions.size());
  for (std::uint32_t v = 0; v < vertex.size(); ++v) vertex[v] = first.try_emplace(scan.positions[v], v).first->second;
  return vertex;
}

// Vertices in the same place are one, triangles without area are gone, vertices without triangles too.
void weld(const TriangleMesh& scan, PreparedScan& prepared) {
  const auto vertex = welded(scan);
  std::vector<std::int64_t> place(scan.positions.size(), -1);
  auto& mesh = prepared.mesh;
  for (std::uint32_t i = 0; i < scan.triangles.size(); ++i) {
    const auto& corners = scan.triangles[i];
    std::array<std::uint32_t, 3> t = {vertex[corners[0]], vertex[corners[1]], vertex[corners[2]]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (auto& v : t) {
      if (place[v] < 0) {
        place[v] = static_cast<std::int64_t>(mesh.positions.size());
        mesh.positions.push_back(scan.positions[v]);
        if (!scan.colours.empty()) mesh.colours.push_back(scan.colours[v]);
      }
      v = static_cast<std::uint32_t>(place[v]);
    }
    mesh.triangles.push_back(t);
    prepared.from_triangle.push_back(i);
  }
  if (mesh.triangles.empty()) throw InvalidInput("the scan's triangles have no area");
}

// Leaves out the vertices that are not `kept`, and their triangles.
void keep(const std::vector<bool>& kept, PreparedScan& prepared) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> place(kept.size(), 0), number;
  for (std::size_t v = 0; v < kept.size(); ++v) {
    if (!kept[v]) continue;
    place[v] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(prepared.mesh.positions[v]);
    if (!prepared.mesh.colours.empty()) mesh.colours.push_back(prepared.mesh.colours[v]);
  }
  for (std::size_t i = 0; i < prepared.mesh.triangles.size(); ++i) {
    const auto& t = prepared.mesh.triangles[i];
    if (!kept[t[0]]) continue;
    mesh.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    number.push_back(prepared.from_triangle[i]);
  }
  prepared.mesh = std::move(mesh);
  prepared.from_triangle = std::move(number);
}

// Dust goes: a piece smaller than a hundredth of the largest that touches nothing else is no part of a body.
void drop_dust(PreparedScan& prepared) {
  const auto pieces = pieces_of(prepared.mesh);
  constexpr double kDust = 0.01;
  const auto is_dust = [&](std::uint32_t piece) { return pieces.areas[piece] < kDust * pieces.areas[0]; };
  std::vector<bool> kept;
  for (const auto piece : pieces.piece) kept.push_back(!is_dust(piece));
  const auto dust = std::count_if(pieces.areas.begin(), pieces.areas.end(),
                                  [&](double area) { return area < kDust * pieces.areas[0]; });
  if (dust == 0) return;
  keep(kept, prepared);
  prepared.notes.push_back(fmt::format("{} pieces smaller than a hundredth of the body are left out", dust));
}

// In metres: parts of a person lie no farther from each other than a wide gap of a scanner.
void join_pieces(PreparedScan& prepared) {
  const auto pieces = pieces_of(prepared.mesh);
  if (pieces.areas.size() == 1) return;
  constexpr double kReach = 0.10;
  const auto bridges = bridge_pieces(prepared.mesh, pieces, kReach);
  if (!bridges.apart.empty()) {
    const double total = std::accumulate(pieces.areas.begin(), pieces.areas.end(), 0.0);
    throw InvalidInput(fmt::format(
        "the scan is not one surface: a piece with {:.0f} % of its area is farther than {:.0f} mm from the rest. Take "
        "away what is not the person, or merge the pieces (Blender: remesh; MeshLab: screened Poisson)",
        100.0 * pieces.areas[bridges.apart.front()] / total, 1000.0 * kReach));
  }
  prepared.bridges = bridges.triangles;
  prepared.notes.push_back(fmt::format("it is in {} pieces, tied to each other over gaps of up to {:.0f} mm",
                                       pieces.areas.size(), 1000.0 * bridges.widest));
}

std::size_t border_edges(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back((static_cast<std::uint64_t>(a) << 32) | b);
    }
  std::sort(edges.begin(), edges.end());
  std::size_t border = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end - i == 1) ++border;
    i = end;
  }
  return border;
}

void stand_up(PreparedScan& prepared) {
  auto& mesh = prepared.mesh;
  const auto stance = find_stance(mesh);
  constexpr Plausible kPerson{0.5, 2.6};
  const auto unit = unit_of(stance.height, kPerson, FileOf::surface);
  if (!unit)
    throw InvalidInput(
        fmt::format("the scan is {:.3g} of its unit high: in none that is used would that be a person", stance.height));
  if (unit->metres != 1.0)
    prepared.notes.push_back(fmt::format("in {}: {:.2f} m high", unit->name, stance.height * unit->metres));
  if (!stance.told.empty()) prepared.notes.push_back(stance.told);
  prepared.height = stance.height * unit->metres;
  prepared.prepared_from_scan = Eigen::Scaling(unit->metres) * stance.upright_from_scan;
  for (auto& p : mesh.positions) p = (prepared.prepared_from_scan * p.cast<double>()).cast<float>();
}

}  // namespace

PreparedScan prepare_scan(const TriangleMesh& scan) {
  check(scan);
  PreparedScan prepared;
  weld(scan, prepared);
  drop_dust(prepared);
  stand_up(prepared);
  join_pieces(prepared);
  if (signed_volume(prepared.mesh) < 0.0) {
    for (auto& t : prepared.mesh.triangles) std::swap(t[1], t[2]);
    prepared.notes.push_back("its triangles faced inwards and were turned");
  }
  if (prepared.mesh.colours.empty()) prepared.notes.push_back("it has no colours: shown grey");
  if (const auto border = border_edges(prepared.mesh); border > 0)
    prepared.notes.push_back(fmt::format("it has holes ({} edges of borders); they stay as they are", border));
  compute_normals(prepared.mesh);
  return prepared;
}

}  // namespace rotunda::recon
