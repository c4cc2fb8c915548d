#pragma once
// Geometry on the unit sphere: which side of a great circle, areas, and the kernel of a 1-ring. Directions are
// Eigen::Vector3d; only their direction matters to orientation() and the kernel, the rest expects unit length.
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace rotunda::recon {

// The sign of det(p, q, r): +1 if the spherical triangle is counter-clockwise seen from outside, -1 if clockwise, 0 if
// the three lie on one great circle. Exact for coordinates that are 0 or at least 1e-60: a floating-point filter,
// then expansion arithmetic (Shewchuk 1997, "Adaptive precision floating-point arithmetic").
int orientation(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r);

// Signed area, steradians in (-2 pi, 2 pi], relatively exact for slivers too (Van Oosterom, Strackee 1983).
double spherical_area(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r);

// An orthonormal frame at a point of the sphere: u, v span the tangent plane and u x v = origin.
struct TangentFrame {
  explicit TangentFrame(const Eigen::Vector3d& unit_origin);
  // The direction that the gnomonic projection at the origin shows at `at`.
  Eigen::Vector3d direction(const Eigen::Vector2d& at) const;

  Eigen::Vector3d origin, u, v;
};

// Kernel of a 1-ring (counter-clockwise from outside): the directions that see every ring edge q r from its left,
// det(x, q, r) > 0. A convex polygon in the gnomonic plane at `near`, cut off 84 degrees away from it; empty if none.
std::vector<Eigen::Vector2d> ring_kernel(std::span<const Eigen::Vector3d> ring, const TangentFrame& near);

// A unit direction well inside the kernel (the polygon's centroid), proved inside by orientation(); none if the
// kernel is empty or too thin for a double. `near` is a unit direction close to the kernel, e.g. one of its corners.
std::optional<Eigen::Vector3d> kernel_point(std::span<const Eigen::Vector3d> ring, const Eigen::Vector3d& near);

// Whether x sees every ring edge from its left, exactly.
bool inside_kernel(const Eigen::Vector3d& x, std::span<const Eigen::Vector3d> ring);

// Where a step from the unit direction x leads on the sphere, shortened (to two fifths, twice) until it ends inside the
// kernel of the ring; x where none of these do.
Eigen::Vector3d step_in_kernel(const Eigen::Vector3d& x, Eigen::Vector3d step, std::span<const Eigen::Vector3d> ring);

}  // namespace rotunda::recon
