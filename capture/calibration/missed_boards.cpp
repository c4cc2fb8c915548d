#include "capture/calibration/missed_boards.h"

#include <Eigen/Geometry>
#include <cmath>

namespace rotunda::capture {
namespace {

// The homography through the corner and four points about it, as the lens bends them.
std::optional<Eigen::Matrix3d> homography_about(const CameraModel& camera, const Eigen::Isometry3d& world_from_board,
                                                const Bend& bend, const Eigen::Vector2d& corner, double half) {
  std::vector<PlacedPoint> points;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    const Eigen::Vector2d at = corner + Eigen::Vector2d(x, y);
    const auto pixel = project(camera, world_from_board * bent(bend, {at.x(), at.y(), 0.0}));
    if (!pixel) return std::nullopt;
    points.push_back({at, *pixel});
  }
  const Eigen::Vector2d middle = points.front().pixel;
  auto H = local_homography(points, corner, points.size());
  if (!H) return std::nullopt;
  const Eigen::Vector2d off = middle - (*H * corner.homogeneous()).hnormalized();
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = off;
  return Eigen::Matrix3d(shift * *H);
}

}  // namespace

Sighting look_where_predicted(const cv::Mat& linear, const RigState& state, const BoardPrint& print,
                              const Sighting& which, const MissedBoardOptions& options) {
  Sighting found = which;
  found.corners.clear();
  const auto& camera = state.cameras[which.camera];
  const auto& world_from_board = state.world_from_board.at({which.moment, which.board});
  const Bend bend = which.board < state.bends.size() ? state.bends[which.board] : Bend{};
  const double blur = which.blur_px > 0.0 ? which.blur_px : options.blur_px;
  const auto positions = corner_positions(print.board());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d way = (camera.centre() - world_from_board * positions[i]).normalized();
    if (way.dot(world_from_board.linear().col(2)) < options.least_cosine) continue;
    const Eigen::Vector2d at = positions[i].head<2>();
    const auto H = homography_about(camera, world_from_board, bend, at, 0.3 * print.board().square);
    if (!H) continue;
    if (const auto fit = fit_corner(linear, print, at, *H, {.blur_px = blur, .reach_px = options.reach_px}))
      found.corners.push_back({static_cast<int>(i), fit->pixel, fit->deviation});
  }
  if (!span_an_area(found.corners, print.board())) found.corners.clear();
  return found;
}

}  // namespace rotunda::capture
