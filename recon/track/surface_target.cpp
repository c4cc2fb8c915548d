#include "recon/track/surface_target.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

#include "config/errors.h"
#include "recon/track/nearest_on_triangle.h"

namespace rotunda::recon {
namespace {

struct PointsOfMesh {
  const TriangleMesh& mesh;
  std::size_t kdtree_get_point_count() const { return mesh.positions.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return mesh.positions[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsOfMesh>, PointsOfMesh, 3>;

// nanoflann's result set of one point, that takes only what faces the same way.
class NearestFacing {
 public:
  using DistanceType = float;
  NearestFacing(const TriangleMesh& mesh, const Eigen::Vector3f& normal, float gate)
      : mesh_(mesh), normal_(normal), squared_(gate * gate) {}
  std::size_t size() const { return found_ ? 1 : 0; }
  bool full() const { return found_.has_value(); }
  float worstDist() const { return squared_; }
  bool addPoint(float squared, std::size_t vertex) {
    if (squared >= squared_ || mesh_.normals[vertex].dot(normal_) < static_cast<float>(kCompatibleNormals)) return true;
    squared_ = squared;
    found_ = static_cast<std::uint32_t>(vertex);
    return true;
  }
  std::optional<std::uint32_t> found() const { return found_; }

 private:
  const TriangleMesh& mesh_;
  Eigen::Vector3f normal_;
  float squared_;
  std::optional<std::uint32_t> found_;
};

}  // namespace

struct SurfaceTarget::Index {
  explicit Index(const TriangleMesh& mesh) : points{mesh}, tree(3, points) {}
  PointsOfMesh points;
  Tree tree;
};

SurfaceTarget::SurfaceTarget(const TriangleMesh& mesh) : mesh_(mesh), triangles_of_(mesh.positions.size()) {
  if (mesh.positions.empty() || mesh.normals.size() != mesh.positions.size())
    throw InvalidInput("a surface to follow needs vertices and their normals");
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const auto corner : mesh.triangles[t]) triangles_of_[corner].push_back(t);
  index_ = std::make_unique<Index>(mesh);
}

SurfaceTarget::~SurfaceTarget() = default;

std::optional<std::uint32_t> SurfaceTarget::closest_vertex(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                                           double gate) const {
  NearestFacing nearest(mesh_, normal.cast<float>(), static_cast<float>(gate));
  const Eigen::Vector3f query = point.cast<float>();
  index_->tree.findNeighbors(nearest, query.data(), nanoflann::SearchParams());
  return nearest.found();
}

std::optional<SurfaceHit> SurfaceTarget::closest(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                                 double gate) const {
  const auto vertex = closest_vertex(point, normal, gate);
  if (!vertex || triangles_of_[*vertex].empty()) return std::nullopt;
  SurfaceHit hit;
  hit.distance = std::numeric_limits<double>::infinity();
  for (const auto triangle : triangles_of_[*vertex]) {
    const auto& t = mesh_.triangles[triangle];
    const Eigen::Vector3d a = mesh_.positions[t[0]].cast<double>(), b = mesh_.positions[t[1]].cast<double>(),
                          c = mesh_.positions[t[2]].cast<double>();
    const Eigen::Vector3d at = nearest_barycentric(point, a, b, c);
    const Eigen::Vector3d on = at[0] * a + at[1] * b + at[2] * c;
    const double distance = (on - point).norm();
    if (distance >= hit.distance) continue;
    hit = {{triangle, at}, on, Eigen::Vector3d::Zero(), distance};
  }
  const auto& t = mesh_.triangles[hit.sample.triangle];
  for (int i = 0; i < 3; ++i)
    hit.normal += hit.sample.barycentric[i] * mesh_.normals[t[static_cast<std::size_t>(i)]].cast<double>();
  hit.normal.normalize();
  return hit;
}

}  // namespace rotunda::recon
