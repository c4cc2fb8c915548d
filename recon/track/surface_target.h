#pragma once
// A surface that another one is moved onto: its nearest point that faces the same way. World frame, metres.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/sphere_locator.h"

namespace rotunda::recon {

// A point faces as another does if the cosine of the angle between their normals is above this.
inline constexpr double kCompatibleNormals = 0.3;

struct SurfaceHit {
  SurfaceSample sample;  // on the mesh
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double distance = 0.0;
};

class SurfaceTarget {
 public:
  // Keeps a reference to the mesh, which has normals. Throws InvalidInput if it has none or no vertex.
  explicit SurfaceTarget(const TriangleMesh& mesh);
  ~SurfaceTarget();
  SurfaceTarget(const SurfaceTarget&) = delete;
  SurfaceTarget& operator=(const SurfaceTarget&) = delete;

  // The nearest vertex that faces as `normal` does, not farther than `gate`, and on its triangles the nearest point.
  std::optional<SurfaceHit> closest(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double gate) const;
  // The vertex alone.
  std::optional<std::uint32_t> closest_vertex(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                              double gate) const;

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  struct Index;
  const TriangleMesh& mesh_;
  std::vector<std::vector<std::uint32_t>> triangles_of_;
  std::unique_ptr<Index> index_;
};

}  // namespace rotunda::recon
