#include "recon/sphere/matching_level.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "recon/sphere/independent_sets.h"
#include "recon/sphere/lattice_snap.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

constexpr double kReach = 3.0;  // T; what is farther weighs less than exp(-9) of what is at hand

// The neighbours of neighbours within a distance, itself first.
void reach_out(const std::vector<std::vector<std::uint32_t>>& rings, const std::vector<Eigen::Vector3d>& directions,
               std::uint32_t from, double reach, std::vector<std::uint32_t>& seen_by,
               std::vector<std::uint32_t>& found) {
  const auto begin = found.size();
  found.push_back(from);
  seen_by[from] = from;
  for (auto i = begin; i < found.size(); ++i)
    for (const auto next : rings[found[i]]) {
      if (seen_by[next] == from) continue;
      seen_by[next] = from;
      if ((directions[next] - directions[from]).squaredNorm() < reach * reach) found.push_back(next);
    }
}

}  // namespace

MatchingLevel::MatchingLevel(int level, std::vector<Feature> from, std::vector<Feature> to,
                             const std::vector<Eigen::Vector3d>& start, const MatchingOptions& options)
    : options_(options),
      level_(level),
      temperature_(edge_length(level)),
      lattice_(weld_lattice(level)),
      rings_(rings_of(lattice_.sample_of_vertex.size(), lattice_.triangles)),
      sets_(independent_sets(
          rings_.size(), [&](std::uint32_t v) -> const auto& { return rings_[v]; })),
      from_(std::move(from)),
      to_(std::move(to)),
      near_(rings_.size(), 0),
      densities_(rings_.size(), 1.0) {
  const auto directions = lattice_directions(level);
  for (const auto sample : lattice_.sample_of_vertex) {
    to_directions_.push_back(directions[sample]);
    points_.push_back(start[sample]);
  }
  for (std::size_t v = 0; v < points_.size(); ++v) set_place(to_[v], to_directions_[v], temperature_);
  find_candidates();
  for (std::uint32_t v = 0; v < near_.size(); ++v) near_[v] = nearest(points_[v], v > 0 ? near_[v - 1] : 0);
}

void MatchingLevel::find_candidates() {
  std::vector<std::uint32_t> seen_by(rings_.size(), std::numeric_limits<std::uint32_t>::max());
  for (std::uint32_t v = 0; v < rings_.size(); ++v) {
    first_.push_back(static_cast<std::uint32_t>(candidates_.size()));
    reach_out(rings_, to_directions_, v, kReach * temperature_, seen_by, candidates_);
  }
  first_.push_back(static_cast<std::uint32_t>(candidates_.size()));
}

// Downhill over the lattice of S'.
std::uint32_t MatchingLevel::nearest(const Eigen::Vector3d& point, std::uint32_t start) const {
  auto at = start;
  for (bool nearer = true; nearer;) {
    nearer = false;
    for (const auto next : rings_[at])
      if (to_directions_[next].dot(point) > to_directions_[at].dot(point)) {
        at = next;
        nearer = true;
      }
  }
  return at;
}

// D(s_i) of eq. (1).
void MatchingLevel::read_densities() {
  std::vector<double> areas(points_.size(), 0.0);
  for (const auto& t : lattice_.triangles) {
    const double area = std::abs(spherical_area(points_[t[0]], points_[t[1]], points_[t[2]]));
    for (const auto corner : t) areas[corner] += area;
  }
  for (std::size_t v = 0; v < areas.size(); ++v)
    densities_[v] = static_cast<double>(rings_[v].size()) / std::max(areas[v], 1e-300);
}

// Eq. (3), D0 = 1.
Eigen::Vector3d MatchingLevel::density_step(std::uint32_t vertex) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (const auto next : rings_[vertex]) {
    const double weight = 1.0 / densities_[next];
    sum += weight * (points_[next] - points_[vertex]);
    weights += weight;
  }
  return sum / weights;
}

// sum_j w_ij (s_j - s_i) for the w_ij of eq. (8) and (9).
Eigen::Vector3d MatchingLevel::pull(std::uint32_t vertex) {
  const auto at = near_[vertex] = nearest(points_[vertex], near_[vertex]);
  auto feature = from_[vertex];
  set_place(feature, points_[vertex], temperature_);
  const auto begin = first_[at], end = first_[at + 1];
  thread_local std::vector<float> distances;
  distances.resize(end - begin);
  float nearest = std::numeric_limits<float>::max();
  for (auto k = begin; k < end; ++k)
    nearest = std::min(nearest, distances[k - begin] = (feature - to_[candidates_[k]]).square().sum());
  constexpr float kFaint = 16.0F;  // 1e-7 of the best match
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (auto k = begin; k < end; ++k) {
    const float behind = distances[k - begin] - nearest;
    if (behind > kFaint) continue;
    const auto weight = static_cast<double>(std::exp(-behind));
    sum += weight * to_directions_[candidates_[k]];
    weights += weight;
  }
  return sum / weights - points_[vertex];
}

// Eq. (10), shortened until the sample stays inside the kernel of its 1-ring. Returns how far it moved.
double MatchingLevel::move(std::uint32_t vertex) {
  std::array<Eigen::Vector3d, 8> corners;  // no vertex of the lattice has more neighbours
  const auto& ring = rings_[vertex];
  for (std::size_t j = 0; j < ring.size(); ++j) corners[j] = points_[ring[j]];
  const double regular = options_.regularity;
  const Eigen::Vector3d step = (1.0 - regular) * pull(vertex) + regular * density_step(vertex);
  const auto moved = step_in_kernel(points_[vertex], step, {corners.data(), ring.size()});
  const double distance = (moved - points_[vertex]).norm();
  points_[vertex] = moved;
  return distance;
}

SphereMatch::Level MatchingLevel::run() {
  SphereMatch::Level result{.level = level_};
  std::vector<double> moved(points_.size(), 0.0);
  do {
    read_densities();
    if (options_.one_by_one)
      for (std::uint32_t v = 0; v < moved.size(); ++v) moved[v] = move(v);
    else
      for (const auto& set : sets_)
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, set.size(), 64), [&](const auto& range) {
          for (auto i = range.begin(); i < range.end(); ++i) moved[set[i]] = move(set[i]);
        });
    result.largest_update = *std::max_element(moved.begin(), moved.end());
    ++result.updates;
  } while (result.largest_update >= options_.smallest_update && result.updates < options_.most_updates);
  return result;
}

std::vector<Eigen::Vector3d> MatchingLevel::directions() const {
  std::vector<Eigen::Vector3d> of_sample;
  for (const auto vertex : lattice_.vertex_of_sample) of_sample.push_back(points_[vertex]);
  return of_sample;
}

}  // namespace rotunda::recon
