#include "simulator/studio/seen_figure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

SeenPoint see(const capture::CameraModel& camera, const Vector3f& position) {
  const Eigen::Vector3d point = position.cast<double>();
  const auto pixel = capture::project(camera, point);
  if (!pixel) return {};
  return {*pixel, camera.R.row(2).dot(point) + camera.t.z()};
}

SurfaceMaterial material_of(const Figure& figure, std::size_t vertex) {
  return figure.material.empty() ? SurfaceMaterial::cloth : figure.material[vertex];
}

}  // namespace

SeenFigure see_figure(const capture::CameraModel& camera, const LitFigures& figures, std::size_t number,
                      const Figure& figure, bool is_closed) {
  const auto &opening = figures.opening[number], &closing = figures.closing[number];
  const Vector3f eye = camera.centre().cast<float>();
  const std::size_t count = opening.positions.size();
  SeenFigure seen{std::vector<SeenPoint>(count), std::vector<SeenPoint>(count), std::vector<SeenLight>(count)};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 512), [&](const auto& vertices) {
    for (std::size_t v = vertices.begin(); v < vertices.end(); ++v) {
      const Vector3f &p = opening.positions[v], &normal = opening.normals[v];
      seen.opening[v] = see(camera, p);
      seen.closing[v] = closing.positions[v] == p ? seen.opening[v] : see(camera, closing.positions[v]);
      const Vector3f to_eye = (eye - p).normalized();
      if (is_closed && normal.dot(to_eye) < -0.5F) continue;  // no triangle at it is seen
      seen.light[v] = seen_light(material_of(figure, v), figures.light[number][v], p, normal, to_eye);
    }
  });
  return seen;
}

cv::Rect box_of(const std::vector<SeenFigure>& seen, const capture::CameraModel& camera) {
  constexpr double kMargin = 3.0;
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (const auto& figure : seen)
    for (const auto* points : {&figure.opening, &figure.closing})
      for (const auto& point : *points) {
        if (point.depth <= 0.0) continue;
        low = low.min(point.pixel.array());
        high = high.max(point.pixel.array());
      }
  low = (low - kMargin).floor().max(0.0);
  high = (high + kMargin + 1.0).ceil().min(Eigen::Array2d(camera.width, camera.height));
  if ((low >= high).any()) return {};
  return {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x() - low.x()),
          static_cast<int>(high.y() - low.y())};
}

double longest_way(const std::vector<SeenFigure>& seen) {
  double longest = 0.0;
  for (const auto& figure : seen)
    for (std::size_t v = 0; v < figure.opening.size(); ++v)
      longest = std::max(longest, (figure.closing[v].pixel - figure.opening[v].pixel).squaredNorm());
  return std::sqrt(longest);
}

}  // namespace rotunda::simulator
