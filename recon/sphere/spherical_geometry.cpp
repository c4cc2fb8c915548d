#include "recon/sphere/spherical_geometry.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace rotunda::recon {
namespace {

// A sum kept without rounding as non-overlapping parts, smallest first.
class ExactSum {
 public:
  void add(double term) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = term + parts_[i];  // two-sum: sum + error is exactly term + part
      const double part_in_sum = sum - term;
      const double error = (term - (sum - part_in_sum)) + (parts_[i] - part_in_sum);
      term = sum;
      if (error != 0.0) parts_[kept++] = error;
    }
    if (term != 0.0) parts_[kept++] = term;
    size_ = kept;
  }
  // The exact product a b c, as four terms.
  void add_product(double a, double b, double c) {
    const double ab = a * b;
    const double ab_error = std::fma(a, b, -ab);
    for (const double x : {ab_error, ab}) {
      const double xc = x * c;
      add(std::fma(x, c, -xc));
      add(xc);
    }
  }
  int sign() const { return size_ == 0 ? 0 : (parts_[size_ - 1] > 0.0 ? 1 : -1); }

 private:
  std::array<double, 24> parts_{};  // six products of four terms
  std::size_t size_ = 0;
};

int exact_orientation(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
  ExactSum det;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    det.add_product(p[i], q[j], r[k]);
    det.add_product(-p[i], q[k], r[j]);
  }
  return det.sign();
}

// The half-plane a x + b y + c > 0 of the gnomonic plane.
using HalfPlane = Eigen::Vector3d;

double height(const HalfPlane& side, const Eigen::Vector2d& at) {
  return side[0] * at[0] + side[1] * at[1] + side[2];
}

// Sutherland, Hodgman 1974: the part of a convex polygon inside one half-plane.
std::vector<Eigen::Vector2d> clip(const std::vector<Eigen::Vector2d>& polygon, const HalfPlane& side) {
  std::vector<Eigen::Vector2d> inside;
  inside.reserve(polygon.size() + 1);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = height(side, a), at_b = height(side, b);
    if (at_a >= 0.0) inside.push_back(a);
    if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0))
      inside.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return inside;
}

// Coordinates in the frame from the difference to its origin, so that near points keep their relative precision.
Eigen::Vector3d in_frame(const Eigen::Vector3d& x, const TangentFrame& frame) {
  const Eigen::Vector3d d = x - frame.origin;
  return {d.dot(frame.u), d.dot(frame.v), 1.0 + d.dot(frame.origin)};
}

// Centroid relative to the first corner; the mean of the corners when the polygon has no area.
Eigen::Vector2d centroid(const std::vector<Eigen::Vector2d>& polygon) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), moment = Eigen::Vector2d::Zero();
  double area = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - polygon[0], b = polygon[(i + 1) % polygon.size()] - polygon[0];
    const double cross = a[0] * b[1] - a[1] * b[0];
    mean += a / static_cast<double>(polygon.size());
    moment += cross * (a + b) / 3.0;
    area += cross;
  }
  const Eigen::Vector2d centre = moment / area;
  return polygon[0] + (area > 0.0 && centre.allFinite() ? centre : mean);
}

}  // namespace

int orientation(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
  double det = 0.0, permanent = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double forward = q[j] * r[k], backward = q[k] * r[j];
    det += p[i] * (forward - backward);
    permanent += std::abs(p[i]) * (std::abs(forward) + std::abs(backward));
  }
  constexpr double kBound = 1e-15;  // above (7 + 56 e) e, e = 2^-53: Shewchuk's bound for this form
  if (std::abs(det) > kBound * permanent) return det > 0.0 ? 1 : -1;
  return exact_orientation(p, q, r);
}

double spherical_area(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
  const double det = p.dot((q - p).cross(r - p));  // differences: no cancellation in small triangles
  return 2.0 * std::atan2(det, 1.0 + p.dot(q) + q.dot(r) + r.dot(p));
}

TangentFrame::TangentFrame(const Eigen::Vector3d& unit_origin) : origin(unit_origin) {
  u = origin.unitOrthogonal();
  v = origin.cross(u);
}

Eigen::Vector3d TangentFrame::direction(const Eigen::Vector2d& at) const {
  return (origin + at[0] * u + at[1] * v).normalized();
}

std::vector<Eigen::Vector2d> ring_kernel(std::span<const Eigen::Vector3d> ring, const TangentFrame& near) {
  constexpr double kHorizon = 9.5;  // tan 84 degrees
  std::vector<Eigen::Vector2d> kernel = {
      {-kHorizon, -kHorizon}, {kHorizon, -kHorizon}, {kHorizon, kHorizon}, {-kHorizon, kHorizon}};
  for (std::size_t i = 0; i < ring.size() && !kernel.empty(); ++i) {
    const Eigen::Vector3d q = in_frame(ring[i], near), r = in_frame(ring[(i + 1) % ring.size()], near);
    kernel = clip(kernel, q.cross(r));
  }
  return kernel;
}

std::optional<Eigen::Vector3d> kernel_point(std::span<const Eigen::Vector3d> ring, const Eigen::Vector3d& near) {
  const TangentFrame frame(near);
  const auto kernel = ring_kernel(ring, frame);
  if (kernel.size() < 3) return std::nullopt;
  const Eigen::Vector3d point = frame.direction(centroid(kernel));
  if (!inside_kernel(point, ring)) return std::nullopt;
  return point;
}

bool inside_kernel(const Eigen::Vector3d& x, std::span<const Eigen::Vector3d> ring) {
  for (std::size_t i = 0; i < ring.size(); ++i)
    if (orientation(x, ring[i], ring[(i + 1) % ring.size()]) <= 0) return false;
  return true;
}

Eigen::Vector3d step_in_kernel(const Eigen::Vector3d& x, Eigen::Vector3d step, std::span<const Eigen::Vector3d> ring) {
  for (int attempt = 0; attempt < 3; ++attempt, step *= 0.4) {
    const Eigen::Vector3d candidate = (x + step).normalized();
    if (inside_kernel(candidate, ring)) return candidate;
  }
  return x;
}

}  // namespace rotunda::recon
