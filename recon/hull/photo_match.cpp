#include "recon/hull/photo_match.h"

#include <algorithm>

#include "recon/hull/photo_fit.h"
#include "recon/mesh/smoothing.h"
#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

constexpr double kPhantom = 0.064;  // metres: air that a hull encloses before a belly between swinging arms
constexpr double kDeepest = 0.032;  // metres: air between limbs that no silhouette shows
constexpr int kNormalRounds = 8;    // means over neighbours: the direction of the surface at large
constexpr int kGainRounds = 12;     // the same of agreements, over some hand's breadth
constexpr float kLoss = 0.05F;      // of correlation, for which a surface goes all the way back
constexpr float kGain = 0.02F;      // the same, for which it goes all the way to where lumps are evened out
constexpr double kLump = 0.040;     // metres: standard deviation of what evens them out
constexpr int kFilterRounds = 4;    // Taubin's: what is finer than two cells is noise of the matching

// Along the vertices' own normals a rough surface would be folded.
void smooth_normals(TriangleMesh& mesh, const VertexRings& rings) {
  compute_normals(mesh);
  for (int round = 0; round < kNormalRounds; ++round) {
    auto next = mesh.normals;
    for (std::size_t v = 0; v < next.size(); ++v) {
      for (const auto n : rings[v]) next[v] += mesh.normals[n];
      next[v].normalize();
    }
    mesh.normals.swap(next);
  }
}

// A mean over neighbours, of vertices that have a weight.
void even(const VertexRings& rings, std::vector<float>& value, std::vector<float>& weight, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    auto next = value, next_weight = weight;
    for (std::size_t v = 0; v < value.size(); ++v) {
      float sum = weight[v] * value[v], weights = weight[v];
      for (const auto n : rings[v]) {
        sum += weight[n] * value[n];
        weights += weight[n];
      }
      next[v] = weights > 0.0F ? sum / weights : 0.0F;
      next_weight[v] = weights / static_cast<float>(1 + rings[v].size());
    }
    value.swap(next);
    weight.swap(next_weight);
  }
}

struct Explained {
  std::vector<float> agreement, seen;
};

Explained explained(TriangleMesh mesh, const PhotoMatch& match, const VertexRings& rings) {
  smooth_normals(mesh, rings);
  const auto views = photo_views(mesh, match.cameras, match.pictures);
  Explained result{std::vector<float>(mesh.positions.size()), std::vector<float>(mesh.positions.size())};
  surface_agreement(mesh, views, {}, result.agreement, result.seen);
  return result;
}

// How much more the pictures agree about `after` than about `before`, over some hand's breadth.
std::vector<float> gains(const TriangleMesh& before, const TriangleMesh& after, const PhotoMatch& match,
                         const VertexRings& rings) {
  const auto was = explained(before, match, rings), is = explained(after, match, rings);
  std::vector<float> gain(rings.size()), known(rings.size());
  for (std::size_t v = 0; v < gain.size(); ++v) {
    gain[v] = is.agreement[v] - was.agreement[v];
    known[v] = is.seen[v] * was.seen[v];
  }
  even(rings, gain, known, kGainRounds);
  return gain;
}

// Where the pictures agree less about what was found than about what was there, the latter stays.
void take_back(const TriangleMesh& before, const PhotoMatch& match, const VertexRings& rings, TriangleMesh& mesh) {
  const auto gain = gains(before, mesh, match, rings);
  for (std::size_t v = 0; v < gain.size(); ++v) {
    const float kept = std::clamp(1.0F + gain[v] / kLoss, 0.0F, 1.0F);
    mesh.positions[v] = before.positions[v] + kept * (mesh.positions[v] - before.positions[v]);
  }
}

// A mean over a vertex and its ring, six neighbours an edge away, spreads by 3/7 of an edge squared along either axis.
int rounds_of(double deviation, const TriangleMesh& mesh, const VertexRings& rings) {
  constexpr int kMost = 400;
  double edges = 0.0, count = 0.0;
  for (std::size_t v = 0; v < rings.size(); ++v)
    for (const auto n : rings[v]) {
      edges += static_cast<double>((mesh.positions[n] - mesh.positions[v]).norm());
      count += 1.0;
    }
  const double relative = deviation * count / edges;
  return static_cast<int>(std::clamp(7.0 / 3.0 * relative * relative, 1.0, static_cast<double>(kMost)));
}

// One pass: every vertex is tried as far as `reach`.
void settle(TriangleMesh& mesh, const PhotoMatch& match, const VertexRings& rings, std::span<const float> rim_distance,
            double reach, bool thinned) {
  smooth_normals(mesh, rings);
  PhotoFitOptions options;
  options.thinned = thinned;
  options.reach = reach * match.metre;
  if (reach > kDeepest) {
    options.even_rounds *= 3;  // the more is tried the more must agree
    options.least_reach = kDeepest * match.metre;
  }
  options.prior_sigma *= match.metre;
  options.rival_distance *= match.metre;
  const auto views = photo_views(mesh, match.cameras, match.pictures);
  const auto offsets = photo_offsets(mesh, rim_distance, views, options);
  for (std::size_t v = 0; v < offsets.size(); ++v) mesh.positions[v] += offsets[v] * mesh.normals[v];
  smooth(mesh, {.rounds = kFilterRounds});
}

// Around what pictures led astray a surface is left with lumps, too deep for the next pass and agreeing with themselves
// like a pattern one period off. So it also starts anew from where its way from `fitted` is evened out, and goes there
// where the pictures agree more.
void try_without_lumps(const TriangleMesh& fitted, const PhotoMatch& match, const VertexRings& rings,
                       std::span<const float> rim_distance, TriangleMesh& mesh) {
  auto other = fitted;
  smooth_normals(other, rings);
  std::vector<float> way(rings.size()), weight(rings.size(), 1.0F);
  for (std::size_t v = 0; v < way.size(); ++v) way[v] = other.normals[v].dot(mesh.positions[v] - fitted.positions[v]);
  even(rings, way, weight, rounds_of(kLump * match.metre, fitted, rings));
  for (std::size_t v = 0; v < way.size(); ++v) other.positions[v] += way[v] * other.normals[v];
  smooth(other, {.rounds = kFilterRounds});
  settle(other, match, rings, rim_distance, 0.75 * kDeepest, true);
  const auto gain = gains(mesh, other, match, rings);
  for (std::size_t v = 0; v < gain.size(); ++v)
    mesh.positions[v] += std::clamp(gain[v] / kGain, 0.0F, 1.0F) * (other.positions[v] - mesh.positions[v]);
}

}  // namespace

void match_to_pictures(TriangleMesh& mesh, const PhotoMatch& match) {
  const auto distance = rim_distances(match.hull, match.rims, match.fit.cell_size, 2.0 * match.fit.law.farthest);
  const VertexRings rings(mesh);
  const auto fitted = mesh;
  settle(mesh, match, rings, distance, kPhantom, true);
  settle(mesh, match, rings, distance, kDeepest, true);
  settle(mesh, match, rings, distance, 0.5 * kDeepest, true);
  try_without_lumps(fitted, match, rings, distance, mesh);
  settle(mesh, match, rings, distance, 0.25 * kDeepest, false);
  take_back(fitted, match, rings, mesh);
  pin_to_rims(mesh, match.hull, match.rims, match.fit);
}

}  // namespace rotunda::recon
