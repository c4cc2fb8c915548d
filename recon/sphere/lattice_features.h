#pragma once
// Private to recon/sphere: what spherical matching compares, eq. (5) and (8) as one squared distance: position, normal,
// colour and place on the sphere of a sample, each divided by its deviation.
#include <Eigen/Core>
#include <vector>

#include "recon/sphere/spherical_matching.h"

namespace rotunda::recon {

// x / sigma_x, n / sigma_n, c / sigma_c, s / T
using Feature = Eigen::Array<float, 12, 1>;

// Of the welded lattice's vertices, a level of the image's own or coarser; s is left zero. Positions about `middle`.
std::vector<Feature> lattice_features(const GeometryImage& image, int level, const Eigen::Vector3f& middle,
                                      const MatchingOptions& options);

// Mean edge of the undeformed sphere's triangles: the temperature T of a level.
double edge_length(int level);

// By area.
Eigen::Vector3f middle_of(const GeometryImage& image);

inline void set_place(Feature& feature, const Eigen::Vector3d& direction, double temperature) {
  feature.tail<3>() = (direction / temperature).cast<float>().array();
}

}  // namespace rotunda::recon
