#include "recon/hull/solid_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace rotunda::recon {
namespace {

using Piece = std::vector<VoxelId>;
using Places = std::vector<Eigen::Vector3i>;  // in samples

std::vector<Piece> pieces_of(const SignedGrid& grid) {
  std::vector<char> open(grid.voxel_count(), 0);
  for (VoxelId id = 0; id < open.size(); ++id) open[id] = grid.value(id) > 0.0F ? 1 : 0;
  std::vector<Piece> pieces;
  for (VoxelId id = 0; id < open.size(); ++id) {
    if (open[id] == 0) continue;
    Piece piece{id};
    open[id] = 0;
    for (std::size_t i = 0; i < piece.size(); ++i)
      grid.for_each_neighbour(piece[i], [&](VoxelId n) {
        if (n == kNoVoxel || open[n] == 0) return;
        open[n] = 0;
        piece.push_back(n);
      });
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

double distance_on_floor(const SignedGrid& grid, const Piece& piece, const Eigen::Vector2d& place) {
  double nearest = std::numeric_limits<double>::max();
  for (const auto id : piece) nearest = std::min(nearest, (grid.position(id).head<2>() - place).squaredNorm());
  return nearest;
}

// Largest first, of equals the first found; then the one asked for before all.
void put_kept_first(const SignedGrid& grid, const PieceRule& rule, std::vector<Piece>& pieces) {
  constexpr std::size_t kNobody = 20;  // a piece so many times smaller than the largest is no person
  std::ranges::stable_sort(pieces, [](const Piece& a, const Piece& b) { return a.size() > b.size(); });
  if (!rule.performer_at || pieces.empty()) return;
  const auto nobody =
      std::ranges::find_if(pieces, [&](const Piece& piece) { return piece.size() * kNobody < pieces.front().size(); });
  const auto nearest = std::min_element(pieces.begin(), nobody, [&](const Piece& a, const Piece& b) {
    return distance_on_floor(grid, a, *rule.performer_at) < distance_on_floor(grid, b, *rule.performer_at);
  });
  std::rotate(pieces.begin(), nearest, nearest + 1);
}

Places outermost(const SignedGrid& grid, const Piece& piece) {
  Places places;
  for (const auto id : piece) {
    bool inner = true;
    grid.for_each_neighbour(id, [&](VoxelId n) { inner = inner && n != kNoVoxel && grid.value(n) > 0.0F; });
    if (!inner) places.push_back(grid.coordinates(id));
  }
  return places;
}

// The two places, one of each, that are nearest to each other; of equals the first.
std::pair<Eigen::Vector3i, Eigen::Vector3i> nearest_pair(const Places& from, const Places& to) {
  using Table = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
  Table table(static_cast<Eigen::Index>(to.size()), 3);
  for (Eigen::Index i = 0; i < table.rows(); ++i) table.row(i) = to[static_cast<std::size_t>(i)].cast<float>();
  const nanoflann::KDTreeEigenMatrixAdaptor<Table, 3, nanoflann::metric_L2_Simple> tree(3, table);
  std::tuple<float, std::size_t, Eigen::Index> best{std::numeric_limits<float>::max(), 0, 0};
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3f query = from[i].cast<float>();
    Eigen::Index found = 0;
    float squared = 0.0F;
    tree.query(query.data(), 1, &found, &squared);
    best = std::min(best, {squared, i, found});
  }
  return {from[std::get<1>(best)], to[static_cast<std::size_t>(std::get<2>(best))]};
}

// From one place to another by steps along the axes, ever nearest to the straight line.
Places thread_between(Eigen::Vector3i at, const Eigen::Vector3i& end) {
  const Eigen::Vector3d way = (end - at).cast<double>();
  const Eigen::Vector3i begin = at;
  Places thread{at};
  while (at != end) {
    double least = std::numeric_limits<double>::max();
    Eigen::Vector3i next = at;
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] == end[axis]) continue;
      Eigen::Vector3i step = at;
      step[axis] += end[axis] > at[axis] ? 1 : -1;
      const double off = (step - begin).cast<double>().cross(way).squaredNorm();
      if (off >= least) continue;
      least = off;
      next = step;
    }
    at = next;
    thread.push_back(at);
  }
  return thread;
}

Eigen::Vector3i block_of(const Eigen::Vector3i& place) {
  return {place.x() >> 3, place.y() >> 3, place.z() >> 3};
}

Places around(const Places& places) {
  Places all;
  for (const auto& place : places)
    for (int i = 0; i < 27; ++i) all.push_back(place + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
  return all;
}

// The same field, with all blocks that these places lie in.
SignedGrid with_blocks_of(const SignedGrid& grid, const Places& places) {
  const auto before = [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<Eigen::Vector3i> blocks;
  for (std::size_t b = 0; b < grid.block_count(); ++b) blocks.push_back(grid.block(b));
  std::set<Eigen::Vector3i, decltype(before)> known(blocks.begin(), blocks.end(), before);
  for (const auto& place : places)
    if (known.insert(block_of(place)).second) blocks.push_back(block_of(place));
  SignedGrid wider(grid.origin(), grid.cell_size(), grid.outside(), std::move(blocks));
  for (std::size_t b = 0; b < grid.block_count(); ++b) wider.values(b) = grid.values(b);
  return wider;
}

// Half a sample thick: the field is half a cell on the thread and minus that beside it.
void lay(const Places& thread, SignedGrid& grid) {
  const auto half = static_cast<float>(0.5 * grid.cell_size());
  const auto beside = around(thread);
  grid = with_blocks_of(grid, beside);
  const auto raise = [&](const Eigen::Vector3i& place, float least) {
    const auto id = grid.find(place);
    grid.set_value(id, std::max(grid.value(id), least));
  };
  for (const auto& place : beside) raise(place, -half);
  for (const auto& place : thread) raise(place, half);
}

}  // namespace

PieceReport settle_pieces(SignedGrid& grid, const PieceRule& rule) {
  auto pieces = pieces_of(grid);
  put_kept_first(grid, rule, pieces);
  PieceReport report{.pieces = pieces.size()};
  const double cell = grid.cell_size() * grid.cell_size() * grid.cell_size();
  std::vector<Places> tied;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const bool tie = rule.tied_volume > 0.0 && static_cast<double>(pieces[p].size()) * cell >= rule.tied_volume;
    if (p > 0 && !tie) {
      report.dropped_voxels += pieces[p].size();
      for (const auto id : pieces[p]) grid.set_value(id, grid.outside());
    } else if (rule.tied_volume > 0.0) {
      tied.push_back(outermost(grid, pieces[p]));
    }
  }
  if (tied.size() < 2) return report;
  report.tied = tied.size() - 1;
  auto whole = std::move(tied.front());
  for (std::size_t p = 1; p < tied.size(); ++p) {
    const auto [from, to] = nearest_pair(tied[p], whole);
    lay(thread_between(from, to), grid);
    whole.insert(whole.end(), tied[p].begin(), tied[p].end());
  }
  return report;
}

}  // namespace rotunda::recon
