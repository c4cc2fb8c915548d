#include "tests/bench/surface_score.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "recon/colour/visibility.h"

namespace rotunda::bench {
namespace {

constexpr std::size_t kPoints = 10000;  // on each surface
constexpr double kNear = 10.0;          // millimetres

std::vector<Eigen::Vector3d> area_points(const recon::TriangleMesh& mesh) {
  auto points = tests::points_on(mesh, kPoints);
  points.erase(points.begin(), points.begin() + static_cast<long>(mesh.positions.size()));
  return points;
}

std::vector<double> distances(const std::vector<Eigen::Vector3d>& points, const tests::DistanceTree& tree) {
  std::vector<double> result(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) { result[i] = 1e3 * tree.distance(points[i]); });
  return result;
}

// 1 for each point of the mesh that some camera has before it.
std::vector<char> seen_points(const recon::TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& points,
                              std::span<const capture::CameraModel> cameras) {
  constexpr double kTolerance = 0.010;  // metres: some pixels of a steep surface
  std::vector<char> seen(points.size(), 0);
  for (const auto& camera : cameras) {
    const auto map = recon::render_depth(mesh, camera);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = capture::project(camera, points[i]);
      if (!pixel) continue;
      const auto x = static_cast<int>(std::lround(map.from_picture(pixel->x())));
      const auto y = static_cast<int>(std::lround(map.from_picture(pixel->y())));
      if (x < 0 || y < 0 || x >= map.depth.cols || y >= map.depth.rows) continue;
      const double depth = camera.R.row(2).dot(points[i]) + camera.t.z();
      if (depth < static_cast<double>(map.depth.at<float>(y, x)) + kTolerance) seen[i] = 1;
    }
  }
  return seen;
}

double share_within(const std::vector<double>& distances_mm, double limit_mm) {
  const auto near = std::count_if(distances_mm.begin(), distances_mm.end(), [&](double d) { return d <= limit_mm; });
  return distances_mm.empty() ? 0.0 : static_cast<double>(near) / static_cast<double>(distances_mm.size());
}

// Twice its area long.
Eigen::Vector3d normal_of(const recon::TriangleMesh& mesh, std::size_t triangle) {
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    return mesh.positions[mesh.triangles[triangle][i]].cast<double>();
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0));
}

}  // namespace

SurfaceJudge::SurfaceJudge(const recon::TriangleMesh& truth, std::span<const capture::CameraModel> cameras)
    : truth_(truth), tree_(truth), points_(area_points(truth)), seen_(seen_points(truth, points_, cameras)) {}

double SurfaceJudge::seen_share() const {
  return static_cast<double>(std::count(seen_.begin(), seen_.end(), 1)) / static_cast<double>(seen_.size());
}

double SurfaceJudge::normals_off(const recon::TriangleMesh& surface) const {
  double sum = 0.0, area = 0.0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto v : surface.triangles[t]) middle += surface.positions[v].cast<double>() / 3.0;
    const Eigen::Vector3d own = normal_of(surface, t), true_one = normal_of(truth_, tree_.nearest(middle).triangle);
    sum += own.norm() * std::atan2(own.cross(true_one).norm(), own.dot(true_one));
    area += own.norm();
  }
  return sum / area * 180.0 / std::numbers::pi;
}

SurfaceScore SurfaceJudge::score(const recon::TriangleMesh& surface) const {
  auto both = distances(points_, tests::DistanceTree(surface));
  const double within = share_within(both, kNear);
  std::vector<double> seen;
  for (std::size_t i = 0; i < both.size(); ++i)
    if (seen_[i] != 0) seen.push_back(both[i]);
  const auto back = distances(area_points(surface), tree_);
  both.insert(both.end(), back.begin(), back.end());
  std::sort(both.begin(), both.end());
  const double sum = std::accumulate(both.begin(), both.end(), 0.0);
  return {sum / static_cast<double>(both.size()), both[both.size() * 95 / 100], within, share_within(seen, kNear),
          normals_off(surface)};
}

double outline_overlap(const recon::TriangleMesh& surface, const std::vector<capture::CameraModel>& cameras,
                       const std::vector<capture::Matte>& mattes) {
  double sum = 0.0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const cv::Mat drawn = recon::render_depth(surface, cameras[i]).depth<1e9F, seen = mattes[i].alpha> 127;
    sum += static_cast<double>(cv::countNonZero(drawn & seen)) / cv::countNonZero(drawn | seen);
  }
  return sum / static_cast<double>(cameras.size());
}

}  // namespace rotunda::bench
