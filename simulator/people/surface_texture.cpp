#include "simulator/people/surface_texture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace rotunda::simulator {
namespace {

// The lower triangle has its right angle at texel (1, 1), the upper one, turned by half a turn, at (cell - 2, cell -
// 2); one texel about each belongs to it too, so that linear filtering never reads a stranger's.
struct Cell {
  int size, edge;  // texels; edge: between the corners of a triangle
  explicit Cell(int texels) : size(texels + 5), edge(texels) {}
};

struct Corners {
  Eigen::Vector2d origin;
  double direction;  // +1 lower, -1 upper
};

Corners corners_of(std::size_t triangle, const Cell& cell, int columns) {
  const auto slot = static_cast<int>(triangle / 2);
  const Eigen::Vector2d corner(slot % columns * cell.size, slot / columns * cell.size);
  if (triangle % 2 == 0) return {corner + Eigen::Vector2d(1.5, 1.5), 1.0};
  return {corner + Eigen::Vector2d::Constant(cell.size - 1.5), -1.0};
}

cv::Vec3b texel(const Eigen::Vector3d& colour) {
  const Eigen::Vector3d c = 255.0 * colour.cwiseMax(0.0).cwiseMin(1.0);
  return {cv::saturate_cast<uchar>(c.x()), cv::saturate_cast<uchar>(c.y()), cv::saturate_cast<uchar>(c.z())};
}

}  // namespace

SurfaceTexture paint_surface(const recon::TriangleMesh& mesh, int texels, const PaintAt& colour) {
  const Cell cell(texels);
  const auto slots = static_cast<double>((mesh.triangles.size() + 1) / 2);
  const int columns = static_cast<int>(std::ceil(std::sqrt(slots)));
  const int rows = static_cast<int>(std::ceil(slots / columns));
  SurfaceTexture texture{cv::Mat(rows * cell.size, columns * cell.size, CV_8UC3, cv::Scalar::all(0)), {}};
  texture.corners.resize(3 * mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t t) {
    const auto place = corners_of(t, cell, columns);
    const Eigen::Vector2d u(place.direction * cell.edge, 0), v(0, place.direction * cell.edge);
    texture.corners[3 * t] = place.origin.cast<float>();
    texture.corners[3 * t + 1] = (place.origin + u).cast<float>();
    texture.corners[3 * t + 2] = (place.origin + v).cast<float>();
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = mesh.positions[mesh.triangles[t][i]].cast<double>();
    for (int j = -1; j <= cell.edge + 1; ++j)
      for (int i = -1; i <= std::min(cell.edge + 1, cell.edge + 1 - j); ++i) {
        const double a = static_cast<double>(i) / cell.edge, b = static_cast<double>(j) / cell.edge;
        const Eigen::Vector2d at = place.origin + place.direction * Eigen::Vector2d(i, j);
        texture.picture.at<cv::Vec3b>(static_cast<int>(at.y()), static_cast<int>(at.x())) =
            texel(colour(t, p[0] + a * (p[1] - p[0]) + b * (p[2] - p[0])));
      }
  });
  return texture;
}

}  // namespace rotunda::simulator
