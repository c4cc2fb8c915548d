#include "playback/surface_pick.h"

#include <limits>

namespace rotunda::playback {
namespace {

using Eigen::Vector3d;

// Rays through an edge must not slip between its triangles.
constexpr double kOverlap = 1e-9;

// Along the ray from the origin, in lengths of its direction (Moeller and Trumbore 1997); nothing if it misses.
std::optional<double> hit(const Vector3d& direction, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, across = direction.cross(ac);
  const double volume = ab.dot(across);
  if (volume == 0.0) return std::nullopt;
  const double u = -a.dot(across) / volume;
  if (u < -kOverlap || u > 1.0 + kOverlap) return std::nullopt;
  const Vector3d around = ab.cross(a);
  const double v = direction.dot(around) / volume;
  if (v < -kOverlap || u + v > 1.0 + kOverlap) return std::nullopt;
  return ac.dot(around) / volume;
}

}  // namespace

std::optional<SurfacePick> pick(const recon::TriangleMesh& mesh, const Viewpoint& viewpoint,
                                const Eigen::Vector2d& pixel) {
  const Vector3d eye = viewpoint.eye();
  // Of depth one in the eye's frame, so that lengths along it are depths.
  const Vector3d direction = viewpoint.R.transpose() * (viewpoint.K.inverse() * pixel.homogeneous());
  std::optional<SurfacePick> found;
  double nearest = std::numeric_limits<double>::infinity();
  const auto corner = [&](std::uint32_t v) -> Vector3d { return mesh.positions[v].cast<double>() - eye; };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto depth = hit(direction, corner(a), corner(b), corner(c));
    if (!depth || *depth <= 0.0 || *depth >= nearest) continue;
    nearest = *depth;
    found = SurfacePick{t, eye + nearest * direction, nearest};
  }
  return found;
}

Eigen::Vector3f outwards(const recon::TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
}

std::optional<Vector3d> seen_at(const Viewpoint& viewpoint, const Vector3d& place) {
  const Vector3d in_eye = viewpoint.R * place + viewpoint.t;
  if (in_eye.z() <= 0.0) return std::nullopt;
  const Vector3d image = viewpoint.K * in_eye;
  return Vector3d(image.x() / in_eye.z(), image.y() / in_eye.z(), in_eye.z());
}

}  // namespace rotunda::playback
