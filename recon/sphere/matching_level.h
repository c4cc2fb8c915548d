#pragma once
// Private to recon/sphere: spherical matching at one level of the subdivided octahedron.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "recon/sphere/lattice_features.h"
#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {

class MatchingLevel {
 public:
  // from, to: of the level's welded vertices; `start`: where S lies, of every sample.
  MatchingLevel(int level, std::vector<Feature> from, std::vector<Feature> to,
                const std::vector<Eigen::Vector3d>& start, const MatchingOptions& options);

  SphereMatch::Level run();                         // until no sample moves far
  std::vector<Eigen::Vector3d> directions() const;  // of every sample

 private:
  void find_candidates();
  std::uint32_t nearest(const Eigen::Vector3d& point, std::uint32_t start) const;
  double move(std::uint32_t vertex);
  Eigen::Vector3d pull(std::uint32_t vertex);
  Eigen::Vector3d density_step(std::uint32_t vertex) const;
  void read_densities();

  const MatchingOptions& options_;
  int level_;
  double temperature_;
  WeldedLattice lattice_;
  std::vector<std::vector<std::uint32_t>> rings_;
  std::vector<std::vector<std::uint32_t>> sets_;
  std::vector<Feature> from_, to_;
  std::vector<Eigen::Vector3d> to_directions_, points_;  // s_j, s_i
  std::vector<std::uint32_t> first_, candidates_;        // samples of S' about each of its samples
  std::vector<std::uint32_t> near_;                      // the sample of S' nearest to s_i
  std::vector<double> densities_;
};

}  // namespace rotunda::recon
