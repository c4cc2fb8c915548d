#include "recon/sphere/vertex_star.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

constexpr double kPower = 3.0;  // a of the energy

double to_power(double x) {
  return x * x * x;
}

}  // namespace

struct VertexStar::Model {
  explicit Model(const Eigen::Vector3d& p) : frame(p) {}
  TangentFrame frame;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
  std::vector<Eigen::Vector2d> slopes;  // of each determinant

  // -H^-1 g with both eigenvalues of H made positive, so that it is a direction of descent.
  Eigen::Vector2d newton_step() const {
    const double mean = 0.5 * hessian.trace();
    const double half = 0.5 * (hessian(0, 0) - hessian(1, 1)), off = hessian(0, 1);
    const double spread = std::hypot(half, off);
    const double floor = 1e-2 * (std::abs(mean) + spread);
    const double large = std::max(std::abs(mean + spread), floor), small = std::max(std::abs(mean - spread), floor);
    if (!(floor > 0.0)) return Eigen::Vector2d::Zero();
    if (spread == 0.0) return -gradient / large;
    Eigen::Vector2d axis(half + spread, off);  // eigenvector of mean + spread
    if (half < 0.0) axis = Eigen::Vector2d(off, spread - half);
    axis.normalize();
    const Eigen::Vector2d across(-axis[1], axis[0]);
    return -axis * (axis.dot(gradient) / large) - across * (across.dot(gradient) / small);
  }
};

void VertexStar::set(std::span<const Eigen::Vector3d> ring, std::span<const double> weights) {
  ring_.assign(ring.begin(), ring.end());
  sides_.resize(ring_.size());
  for (std::size_t j = 0; j < ring_.size(); ++j) {
    const auto &q = ring_[j], &r = ring_[j + 1 == ring_.size() ? 0 : j + 1];
    sides_[j] = {q, r, q.cross(r), (q - r).squaredNorm(), to_power(weights[j])};
  }
}

double VertexStar::energy(const Eigen::Vector3d& p) const {
  constexpr double kCertain = 1e-14;  // above any rounding error of p . normal
  double sum = 0.0;
  for (const auto& side : sides_) {
    const double det = p.dot(side.normal);
    if (det < kCertain && (det < -kCertain || orientation(p, side.q, side.r) <= 0))
      return std::numeric_limits<double>::infinity();
    const double edges = (p - side.q).squaredNorm() + (p - side.r).squaredNorm() + side.opposite_squared;
    sum += side.weight * edges / to_power(det);
  }
  return std::isnan(sum) ? std::numeric_limits<double>::infinity() : sum;
}

// e = w^a N / D^a along p' = (p + t) / |p + t|: to second order D' = D + t.normal - |t|^2 D / 2 and, with
// N = const - 2 p.(q + r), N' = N - 2 t.(q + r) + |t|^2 p.(q + r).
VertexStar::Model VertexStar::model_at(const Eigen::Vector3d& p) const {
  Model model(p);
  model.slopes.reserve(sides_.size());
  for (const auto& side : sides_) {
    const double d = std::max(p.dot(side.normal), 1e-14), w = side.weight / to_power(d);
    const double n = (p - side.q).squaredNorm() + (p - side.r).squaredNorm() + side.opposite_squared;
    const Eigen::Vector3d sum = side.q + side.r;
    const Eigen::Vector2d slope_d(model.frame.u.dot(side.normal), model.frame.v.dot(side.normal));
    const Eigen::Vector2d slope_n(-2.0 * model.frame.u.dot(sum), -2.0 * model.frame.v.dot(sum));
    const Eigen::Matrix2d mixed = slope_n * slope_d.transpose();
    model.gradient += w * (slope_n - (kPower * n / d) * slope_d);
    model.hessian += w * ((kPower * (kPower + 1.0) * n / (d * d)) * slope_d * slope_d.transpose() -
                          (kPower / d) * (mixed + mixed.transpose()));
    model.hessian.diagonal().array() += w * (2.0 * p.dot(sum) + kPower * n);
    model.slopes.push_back(slope_d / d);
  }
  return model;
}

Eigen::Vector3d VertexStar::improved(const Eigen::Vector3d& p, double stretch) const {
  constexpr double kStay = 0.9;  // at most this share of the way to the nearest ring edge
  const double before = energy(p);
  const auto model = model_at(p);
  const Eigen::Vector2d step = model.newton_step();
  double length = stretch;
  for (const auto& slope : model.slopes)
    if (slope.dot(step) * length < -kStay) length = -kStay / slope.dot(step);
  for (int halving = 0; halving < 6; ++halving, length *= 0.4) {
    const Eigen::Vector3d candidate = model.frame.direction(length * step);
    if (energy(candidate) < before) return candidate;
  }
  return p;
}

}  // namespace rotunda::recon
