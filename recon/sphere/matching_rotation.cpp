#include "recon/sphere/matching_rotation.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "recon/sphere/lattice_features.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {
namespace {

constexpr int kCoarse = 3, kFine = 4;                 // levels at which rotations are compared
constexpr int kRolls = 20;                            // about each of the coarse level's 66 directions
constexpr std::size_t kKept = 4;                      // of which better ones are sought
constexpr double kFirstStep = 10.0, kLastStep = 1.0;  // degrees

// The cost of a rotation at one level: with W as eq. (8) and (9) give it, what eq. (4) to (6) sum up to is the free
// energy of each sample, - log sum_j w'_ij, but for constants.
class RotationCost {
 public:
  RotationCost(const GeometryImage& from, const GeometryImage& to, int level, const MatchingOptions& options)
      : from_(lattice_features(from, level, middle_of(from), options)),
        to_(lattice_features(to, level, middle_of(to), options)),
        temperature_(edge_length(level)) {
    const auto all = lattice_directions(level);
    for (const auto sample : weld_lattice(level).sample_of_vertex) directions_.push_back(all[sample]);
    for (std::size_t v = 0; v < to_.size(); ++v) set_place(to_[v], directions_[v], temperature_);
  }

  double operator()(const Eigen::Matrix3d& rotation) const {
    double cost = 0.0;
    std::vector<float> distances(to_.size());
    for (std::size_t i = 0; i < from_.size(); ++i) {
      auto feature = from_[i];
      set_place(feature, rotation * directions_[i], temperature_);
      float nearest = std::numeric_limits<float>::max();
      for (std::size_t j = 0; j < to_.size(); ++j)
        nearest = std::min(nearest, distances[j] = (feature - to_[j]).square().sum());
      float sum = 0.0F;
      for (const float distance : distances) sum += std::exp(nearest - distance);
      cost += static_cast<double>(nearest - std::log(sum));
    }
    return cost;
  }

 private:
  std::vector<Feature> from_, to_;
  std::vector<Eigen::Vector3d> directions_;
  double temperature_;
};

std::vector<Eigen::Matrix3d> even_rotations() {
  std::vector<Eigen::Matrix3d> rotations;
  const auto all = lattice_directions(kCoarse);
  for (const auto sample : weld_lattice(kCoarse).sample_of_vertex) {
    const auto tilt = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), all[sample]);
    for (int roll = 0; roll < kRolls; ++roll)
      rotations.push_back((tilt * Eigen::AngleAxisd(2.0 * std::numbers::pi * roll / kRolls, Eigen::Vector3d::UnitZ()))
                              .toRotationMatrix());
  }
  return rotations;
}

std::pair<double, Eigen::Matrix3d> made_finer(const RotationCost& cost, Eigen::Matrix3d rotation) {
  double least = cost(rotation);
  for (double step = kFirstStep; step >= kLastStep;) {
    bool better = false;
    for (int axis = 0; axis < 3; ++axis)
      for (const double turn : {step, -step}) {
        const Eigen::Matrix3d candidate =
            Eigen::AngleAxisd(turn * std::numbers::pi / 180.0, Eigen::Vector3d::Unit(axis)) * rotation;
        const double costs = cost(candidate);
        if (costs >= least) continue;
        least = costs;
        rotation = candidate;
        better = true;
      }
    if (!better) step *= 0.5;
  }
  return {least, rotation};
}

}  // namespace

Eigen::Matrix3d least_cost_rotation(const GeometryImage& from, const GeometryImage& to,
                                    const MatchingOptions& options) {
  const RotationCost coarse(from, to, std::min(kCoarse, from.level), options);
  const auto rotations = even_rotations();
  std::vector<std::pair<double, std::size_t>> costs(rotations.size());
  tbb::parallel_for(std::size_t{0}, rotations.size(), [&](std::size_t i) { costs[i] = {coarse(rotations[i]), i}; });
  std::partial_sort(costs.begin(), costs.begin() + kKept, costs.end());
  const RotationCost fine(from, to, std::min(kFine, from.level), options);
  std::vector<std::pair<double, Eigen::Matrix3d>> best(kKept);
  tbb::parallel_for(std::size_t{0}, kKept,
                    [&](std::size_t i) { best[i] = made_finer(fine, rotations[costs[i].second]); });
  return std::min_element(best.begin(), best.end(), [](const auto& a, const auto& b) { return a.first < b.first; })
      ->second;
}

}  // namespace rotunda::recon
