#include "recon/body/template_rim.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace rotunda::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Corner {
  Vector2d pixel;
  std::uint32_t vertex;
};

// One convex part of the silhouette, corners in the order in which the normal (dy, -dx) points outwards.
struct Hull {
  std::vector<Corner> corners;
  Vector2d low, high;
  std::uint8_t segment = 0;
};

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Andrew's monotone chain (1979).
std::vector<Corner> convex_hull(std::vector<Corner> points) {
  std::sort(points.begin(), points.end(), [](const Corner& a, const Corner& b) {
    return a.pixel.x() != b.pixel.x() ? a.pixel.x() < b.pixel.x() : a.pixel.y() < b.pixel.y();
  });
  std::vector<Corner> hull(2 * points.size());
  std::size_t k = 0;
  const auto add = [&](const Corner& point, std::size_t least) {
    while (k >= least && cross(hull[k - 1].pixel - hull[k - 2].pixel, point.pixel - hull[k - 2].pixel) <= 0.0) --k;
    hull[k++] = point;
  };
  for (const auto& point : points) add(point, 2);
  for (std::size_t i = points.size() - 1, least = k + 1; i-- > 0;) add(points[i], least);
  hull.resize(k - 1);
  return hull;
}

std::optional<Hull> hull_of(const PosedVertices& vertices, std::size_t first, std::size_t last,
                            const capture::CameraModel& camera) {
  std::vector<Corner> points;
  points.reserve(last - first);
  for (std::size_t v = first; v < last; ++v) {
    const auto pixel = capture::project(camera, vertices[v]);
    if (!pixel) return std::nullopt;
    points.push_back({*pixel, static_cast<std::uint32_t>(v)});
  }
  Hull hull{.corners = convex_hull(std::move(points)), .low = {}, .high = {}};
  if (hull.corners.size() < 3) return std::nullopt;
  hull.low = hull.high = hull.corners.front().pixel;
  for (const auto& corner : hull.corners) {
    hull.low = hull.low.cwiseMin(corner.pixel);
    hull.high = hull.high.cwiseMax(corner.pixel);
  }
  return hull;
}

// A segment's convex parts as ranges of its vertices: one, but the head's neck is thinner than its head.
std::vector<Hull> all_hulls(const PosedVertices& vertices, const capture::CameraModel& camera) {
  constexpr std::size_t kHead = 3;
  const std::size_t n = vertices_of_segment(), ring = (n - 2) / 7;
  std::vector<Hull> hulls;
  const auto add = [&](std::size_t segment, std::size_t first, std::size_t last) {
    if (auto hull = hull_of(vertices, segment * n + first, segment * n + last, camera)) {
      hull->segment = static_cast<std::uint8_t>(segment);
      hulls.push_back(std::move(*hull));
    }
  };
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    if (s == kHead) {
      add(s, 0, 1 + 3 * ring);
      add(s, 1 + 2 * ring, n);
    } else {
      add(s, 0, n);
    }
  }
  return hulls;
}

bool is_inside(const Vector2d& pixel, const Hull& hull) {
  constexpr double kDepth = 0.75;  // pixels: what only touches another segment's edge is still rim
  if (!((pixel.array() > hull.low.array()).all() && (pixel.array() < hull.high.array()).all())) return false;
  for (std::size_t i = 0; i < hull.corners.size(); ++i) {
    const Vector2d& a = hull.corners[i].pixel;
    const Vector2d edge = hull.corners[(i + 1) % hull.corners.size()].pixel - a;
    if (cross(edge, pixel - a) < kDepth * edge.norm()) return false;
  }
  return true;
}

void add_edge(std::vector<RimPoint>& rim, const PosedVertices& vertices, const std::vector<Hull>& hulls,
              const Hull& hull, std::size_t i, double& walked, double spacing) {
  const auto &a = hull.corners[i], &b = hull.corners[(i + 1) % hull.corners.size()];
  const Vector2d edge = b.pixel - a.pixel;
  const double length = edge.norm();
  if (length < 1e-9) return;
  const Vector2d normal(edge.y() / length, -edge.x() / length);
  double at = spacing - walked;
  for (; at <= length; at += spacing) {
    const double mix = at / length;
    const Vector2d pixel = a.pixel + mix * edge;
    const bool inner = std::any_of(hulls.begin(), hulls.end(),
                                   [&](const Hull& other) { return &other != &hull && is_inside(pixel, other); });
    if (!inner)
      rim.push_back({(1.0 - mix) * vertices[a.vertex] + mix * vertices[b.vertex], pixel, normal, a.vertex, b.vertex,
                     mix, hull.segment});
  }
  walked = length - (at - spacing);
}

}  // namespace

PosedVertices posed_vertices(const BodyTemplate& body, const JointTransforms& transforms) {
  PosedVertices vertices;
  vertices.reserve(kBodySegments * vertices_of_segment());
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    const auto& world_from_joint = transforms[index(joint_of_segment(s))];
    for (const auto& vertex : body.segments[s].vertices) vertices.push_back(world_from_joint * vertex);
  }
  return vertices;
}

std::vector<RimPoint> template_rim(const PosedVertices& vertices, const capture::CameraModel& camera,
                                   double spacing_px) {
  const auto hulls = all_hulls(vertices, camera);
  std::vector<RimPoint> rim;
  for (const auto& hull : hulls) {
    double walked = 0.5 * spacing_px;
    for (std::size_t i = 0; i < hull.corners.size(); ++i) add_edge(rim, vertices, hulls, hull, i, walked, spacing_px);
  }
  return rim;
}

Eigen::Matrix<double, 2, 3> pixel_jacobian(const capture::CameraModel& camera, const Vector3d& point) {
  const Vector3d p = camera.R * point + camera.t;
  Eigen::Matrix<double, 2, 3> ideal;
  ideal << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
  return camera.K.topLeftCorner<2, 2>() * ideal * camera.R;
}

}  // namespace rotunda::recon
