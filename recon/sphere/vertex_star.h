#pragma once
// Private to recon/sphere: one vertex of a spherical mesh with its triangles, and the best place for it.
//
// The energy of a spherical triangle p q r that stands for the weight w is
//     e = w^2 (|p-q|^2 + |q-r|^2 + |r-p|^2) / det(p, q, r)^2 ,
// up to a factor the L2 stretch (Sander et al. 2001) of an equilateral triangle of area w mapped onto p q r. Minimising
// the sum brings every area to its share of w (even density, eq. (1)-(2) with D0 ~ w) and the shapes to equilateral;
// it grows without bound before a triangle flips. In p both the numerator and det are linear on the sphere.
#include <Eigen/Core>
#include <span>
#include <vector>

namespace rotunda::recon {

class VertexStar {
 public:
  // ring: neighbours counter-clockwise, unit; weights: of the triangles (vertex, ring[j], ring[j + 1]).
  void set(std::span<const Eigen::Vector3d> ring, std::span<const double> weights);

  // Infinite where a triangle of the star would not be counter-clockwise (exact).
  double energy(const Eigen::Vector3d& p) const;

  // Newton step with line search from a p inside the kernel: never leaves the kernel, never raises the energy.
  // `stretch` > 1 lengthens the step first (over-relaxation).
  Eigen::Vector3d improved(const Eigen::Vector3d& p, double stretch = 1.0) const;

  std::span<const Eigen::Vector3d> ring() const { return ring_; }

 private:
  struct Side {
    Eigen::Vector3d q, r, normal;  // normal = q x r, so det(p, q, r) = p . normal
    double opposite_squared;       // |q - r|^2
    double weight_squared;
  };
  struct Model;  // gradient and Hessian in the tangent plane
  Model model_at(const Eigen::Vector3d& p) const;

  std::vector<Eigen::Vector3d> ring_;
  std::vector<Side> sides_;
};

}  // namespace rotunda::recon
