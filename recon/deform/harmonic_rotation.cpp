#include "recon/deform/harmonic_rotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "config/errors.h"
#include "recon/deform/lane_rows.h"

namespace rotunda::recon {
namespace {

constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();

std::vector<std::uint32_t> handle_of_vertices(const HeldLaplacian& system, std::size_t vertices) {
  std::vector<std::uint32_t> handle(vertices, kUnknown);
  for (const auto& held : system.held) handle[held.vertex] = held.handle;
  return handle;
}

// What the held neighbours of free vertices give them, for the handles first ... first + columns.
void fill_border(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights, const HeldLaplacian& system,
                 const std::vector<std::uint32_t>& handle, std::size_t first, LaneRows& rows) {
  const std::size_t columns = LaneRows::stride();
  std::fill_n(rows.data(), rows.size(), 0.0F);
  const auto give = [&](std::uint32_t to, std::uint32_t from, float weight) {
    if (handle[to] != kUnknown || handle[from] == kUnknown) return;
    if (handle[from] >= first && handle[from] < first + columns)
      rows.row(system.place[to])[handle[from] - first] += weight;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = mesh.triangles[t][(k + 1) % 3], b = mesh.triangles[t][(k + 2) % 3];
      give(a, b, weights[t][k]);
      give(b, a, weights[t][k]);
    }
}

}  // namespace

HeldLaplacian hold(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                   std::span<const HeldVertex> held) {
  HeldLaplacian system{.held = {held.begin(), held.end()}, .place = {}, .free = 0, .factor = {}};
  const std::size_t vertices = mesh.positions.size();
  std::vector<int> row(vertices, 0);
  for (const auto& one : held) {
    if (one.vertex >= vertices || row[one.vertex] < 0)
      throw InvalidInput(fmt::format("vertex {} of {} is held twice or not there", one.vertex, vertices));
    row[one.vertex] = -1;
  }
  int rows = 0;
  for (auto& r : row)
    if (r >= 0) r = rows++;
  system.free = static_cast<std::size_t>(rows);
  system.factor = factorise(laplacian(mesh, weights, row, rows));
  std::vector<std::uint32_t> place_of_row(system.free);
  for (std::size_t i = 0; i < system.free; ++i)
    place_of_row[static_cast<std::size_t>(system.factor.order[i])] = static_cast<std::uint32_t>(i);
  system.place.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    if (row[v] >= 0) system.place[v] = place_of_row[static_cast<std::size_t>(row[v])];
  for (std::size_t i = 0; i < held.size(); ++i)
    system.place[held[i].vertex] = static_cast<std::uint32_t>(system.free + i);
  return system;
}

HandleShares harmonic_shares(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                             const HeldLaplacian& system, std::size_t handles) {
  const auto handle = handle_of_vertices(system, mesh.positions.size());
  HandleShares shares =
      HandleShares::Zero(static_cast<Eigen::Index>(mesh.positions.size()), static_cast<Eigen::Index>(handles));
  for (const auto& held : system.held) shares(held.vertex, held.handle) = 1.0F;
  LaneRows rows(system.free);
  for (std::size_t first = 0; first < handles; first += LaneRows::stride()) {
    fill_border(mesh, weights, system, handle, first, rows);
    solve_lanes(system.factor, rows.data());
    const std::size_t columns = std::min(LaneRows::stride(), handles - first);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      for (std::size_t h = 0; handle[v] == kUnknown && h < columns; ++h)
        shares(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(first + h)) =
            std::clamp(rows.row(system.place[v])[h], 0.0F, 1.0F);
  }
  shares.array().colwise() /= shares.rowwise().sum().array();
  return shares;
}

}  // namespace rotunda::recon
