#include "recon/colour/visibility.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

// A vertex in the depth map: x, y in its pixels, and 1/z, which is linear there.
struct Corner {
  double x = 0.0, y = 0.0, inverse_depth = 0.0;  // 0 if the camera cannot project it
};

std::vector<Corner> corners_of(const TriangleMesh& mesh, const capture::CameraModel& camera, const DepthMap& map) {
  std::vector<Corner> corners(mesh.positions.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d position = mesh.positions[i].cast<double>();
    const auto pixel = capture::project(camera, position);
    if (!pixel || !pixel->allFinite()) continue;
    const double depth = camera.R.row(2).dot(position) + camera.t.z();
    corners[i] = {map.from_picture(pixel->x()), map.from_picture(pixel->y()), 1.0 / depth};
  }
  return corners;
}

// Twice the signed area of a, b and the point.
double area(const Corner& a, const Corner& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// The pixel centres between the bounds, clipped to 0..count; casts only what fits an int.
std::array<int, 2> pixels_between(double low, double high, int count) {
  const double first = std::ceil(std::clamp(low, 0.0, static_cast<double>(count)));
  const double last = std::floor(std::clamp(high, -1.0, static_cast<double>(count - 1)));
  return {static_cast<int>(first), static_cast<int>(last)};
}

void draw(cv::Mat& depth, const Corner& a, const Corner& b, const Corner& c) {
  const double whole = area(a, b, c.x, c.y);
  if (whole == 0.0) return;
  const auto columns = pixels_between(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), depth.cols);
  const auto rows = pixels_between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), depth.rows);
  constexpr double kOnEdge = -1e-9;  // neighbours both draw their common edge: no gaps
  for (int y = rows[0]; y <= rows[1]; ++y) {
    auto* row = depth.ptr<float>(y);
    for (int x = columns[0]; x <= columns[1]; ++x) {
      const double at_a = area(b, c, x, y) / whole, at_b = area(c, a, x, y) / whole, at_c = 1.0 - at_a - at_b;
      if (std::min({at_a, at_b, at_c}) < kOnEdge) continue;
      const double inverse = at_a * a.inverse_depth + at_b * b.inverse_depth + at_c * c.inverse_depth;
      row[x] = std::min(row[x], static_cast<float>(1.0 / inverse));
    }
  }
}

}  // namespace

DepthMap render_depth(const TriangleMesh& mesh, const capture::CameraModel& camera, int downscale) {
  if (camera.width < 1 || camera.height < 1 || downscale < 1)
    throw InvalidInput(fmt::format("{}: no depth map of {} x {} pixels, downscale {}", camera.name, camera.width,
                                   camera.height, downscale));
  const cv::Size size((camera.width + downscale - 1) / downscale, (camera.height + downscale - 1) / downscale);
  DepthMap map{cv::Mat(size, CV_32FC1, cv::Scalar(std::numeric_limits<float>::infinity())), downscale};
  const auto corners = corners_of(mesh, camera, map);
  for (const auto& triangle : mesh.triangles) {
    const Corner &a = corners[triangle[0]], &b = corners[triangle[1]], &c = corners[triangle[2]];
    if (a.inverse_depth > 0.0 && b.inverse_depth > 0.0 && c.inverse_depth > 0.0) draw(map.depth, a, b, c);
  }
  return map;
}

}  // namespace rotunda::recon
