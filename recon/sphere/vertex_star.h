#pragma once
// Private to recon/sphere: one vertex of a spherical mesh with its triangles, and the best place for it.
//
// The energy of a spherical triangle p q r that stands for the weight w is
//     e = (w / det(p, q, r))^a (|p-q|^2 + |q-r|^2 + |r-p|^2) ,   a = 3 .
// With a = 2 it is, up to a factor, the L2 stretch (Sander et al. 2001) of an equilateral triangle of area w mapped
// onto p q r; a larger a asks for even areas more than for good shapes. Minimising the sum brings every area near its
// share of w (even density, eq. (1)-(2) with D0 ~ w); e grows without bound before a triangle flips. On the sphere both
// det and the sum of squares are linear in p.
// a: on 20k-triangle bodies the 95th over the 5th percentile of area per vertex is 8-10 (a = 2), 5-6 (2.5), 3.5-4 (3);
// what a larger a costs in shape, the relaxed lattice gives back (relaxed_lattice.h).
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
    double weight;                 // w^a
  };
  struct Model;  // gradient and Hessian in the tangent plane
  Model model_at(const Eigen::Vector3d& p) const;

  std::vector<Eigen::Vector3d> ring_;
  std::vector<Side> sides_;
};

}  // namespace rotunda::recon
