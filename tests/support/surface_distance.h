#pragma once
// Distances from points to a triangle mesh, for measuring against truth. Metres.
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::tests {

// Closest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5).
inline Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                           const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + ab * (d1 / (d1 - d3));
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double sum = va + vb + vc;
  return a + ab * (vb / sum) + ac * (vc / sum);
}

// A binary tree of boxes over the triangles of a mesh.
class DistanceTree {
 public:
  explicit DistanceTree(const recon::TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    nodes_.reserve(2 * order_.size());
    build(0, order_.size());
  }

  double distance(const Eigen::Vector3d& p) const { return nearest(p).distance; }

  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = 0;
  };
  Nearest nearest(const Eigen::Vector3d& p) const {
    Nearest best;  // of the distance squared, meanwhile
    search(0, p, best);
    return {std::sqrt(best.distance), best.triangle};
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::size_t begin, end, right;  // leaf: right = 0; the left child follows its parent
  };
  Eigen::Vector3d corner(std::uint32_t t, std::size_t i) const {
    return mesh_.positions[mesh_.triangles[t][i]].cast<double>();
  }

  std::size_t build(std::size_t begin, std::size_t end) {
    const auto at = nodes_.size();
    Eigen::AlignedBox3d box;
    for (auto i = begin; i < end; ++i)
      for (std::size_t k = 0; k < 3; ++k) box.extend(corner(order_[i], k));
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= 4) return at;
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto middle = (begin + end) / 2;
    const auto centre = [&](std::uint32_t t) { return corner(t, 0)[axis] + corner(t, 1)[axis] + corner(t, 2)[axis]; };
    const auto first = order_.begin();
    std::nth_element(first + static_cast<long>(begin), first + static_cast<long>(middle),
                     first + static_cast<long>(end), [&](auto a, auto b) { return centre(a) < centre(b); });
    build(begin, middle);
    const auto right = build(middle, end);
    nodes_[at].right = right;
    return at;
  }

  void search(std::size_t at, const Eigen::Vector3d& p, Nearest& best) const {
    const auto& node = nodes_[at];
    if (node.box.squaredExteriorDistance(p) >= best.distance) return;
    if (node.right == 0) {
      for (auto i = node.begin; i < node.end; ++i) {
        const auto t = order_[i];
        const double squared = (closest_on_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2)) - p).squaredNorm();
        if (squared < best.distance) best = {squared, t};
      }
      return;
    }
    std::size_t near = at + 1, far = node.right;
    if (nodes_[far].box.squaredExteriorDistance(p) < nodes_[near].box.squaredExteriorDistance(p)) std::swap(near, far);
    search(near, p, best);
    search(far, p, best);
  }

  const recon::TriangleMesh& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// Points spread evenly over a mesh's area, and its vertices.
inline std::vector<Eigen::Vector3d> points_on(const recon::TriangleMesh& mesh, std::size_t count, unsigned seed = 1) {
  std::vector<double> area;
  const auto corner = [&](std::size_t t, std::size_t i) -> Eigen::Vector3d {
    return mesh.positions[mesh.triangles[t][i]].cast<double>();
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    area.push_back((corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm());
  std::mt19937 random(seed);
  std::discrete_distribution<std::size_t> pick(area.begin(), area.end());
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (const auto& position : mesh.positions) points.push_back(position.cast<double>());
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = pick(random);
    const double r = std::sqrt(uniform(random)), s = uniform(random);
    points.push_back((1.0 - r) * corner(t, 0) + r * (1.0 - s) * corner(t, 1) + r * s * corner(t, 2));
  }
  return points;
}

struct PointDistance {
  Eigen::Vector3d point;
  double distance;
};

// From `count` points spread over `from`, and its vertices, to the surface of `to`.
inline std::vector<PointDistance> point_distances(const recon::TriangleMesh& from, const recon::TriangleMesh& to,
                                                  std::size_t count) {
  const DistanceTree tree(to);
  const auto points = points_on(from, count);
  std::vector<PointDistance> distances(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    distances[i] = {points[i], tree.distance(points[i])};
  });
  return distances;
}

struct SurfaceDistance {
  double mean = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
};

inline SurfaceDistance summary_of(std::span<const PointDistance> points) {
  if (points.empty()) return {};
  std::vector<double> distances;
  for (const auto& point : points) distances.push_back(point.distance);
  std::sort(distances.begin(), distances.end());
  const auto quantile = [&](double q) { return distances[static_cast<std::size_t>(q * double(distances.size() - 1))]; };
  const double sum = std::accumulate(distances.begin(), distances.end(), 0.0);
  return {sum / double(distances.size()), quantile(0.95), quantile(0.99), distances.back()};
}

// Both ways, `count` points and all vertices each.
inline SurfaceDistance symmetric_distance(const recon::TriangleMesh& a, const recon::TriangleMesh& b,
                                          std::size_t count) {
  auto distances = point_distances(a, b, count);
  const auto back = point_distances(b, a, count);
  distances.insert(distances.end(), back.begin(), back.end());
  return summary_of(distances);
}

}  // namespace rotunda::tests
