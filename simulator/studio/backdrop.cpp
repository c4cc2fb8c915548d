#include "simulator/studio/backdrop.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr float kNoFloor = 1e6F;

// What lies on the floor or close over it darkens it more than the shadow maps can tell: their cells are too coarse.
struct Layer {
  double below;     // metres
  double spread;    // standard deviation of its shadow's edge, metres
  double strength;  // optical depth of full cover
};
constexpr std::array<Layer, 2> kLayers = {{{0.06, 0.014, 1.4}, {0.25, 0.05, 0.45}}};

constexpr double kCell = 0.0125;
constexpr int kCells = 352;  // 4.4 m

using Cover = std::array<cv::Mat, kLayers.size()>;

void add_cover(const recon::TriangleMesh& body, const ContactShadow& grid, Cover& cover) {
  for (const auto& t : body.triangles) {
    const Eigen::Vector3f a = body.positions[t[0]], b = body.positions[t[1]], c = body.positions[t[2]];
    const Eigen::Vector3f middle = (a + b + c) / 3.0F;
    const float area = -0.5F * (b - a).cross(c - a).z();  // of what faces the floor
    const int column = cvRound((middle.x() - grid.from_x) / kCell), row = cvRound((middle.y() - grid.from_y) / kCell);
    if (area <= 0.0F || column < 0 || row < 0 || column >= kCells || row >= kCells) continue;
    std::size_t layer = 0;
    while (layer < kLayers.size() && middle.z() > kLayers[layer].below) ++layer;
    if (layer == kLayers.size()) continue;
    cover[layer].at<float>(row, column) += area / static_cast<float>(kCell * kCell);
  }
}

Cover cover_of(const std::vector<recon::TriangleMesh>& surfaces, const ContactShadow& grid) {
  Cover cover;
  for (auto& layer : cover) layer = cv::Mat(kCells, kCells, CV_32FC1, cv::Scalar(0));
  for (const auto& surface : surfaces) add_cover(surface, grid, cover);
  return cover;
}

// Of lamps and walls, softly; the outermost metre runs out to full light, where the grid ends.
cv::Mat lamp_shadow(const ContactShadow& grid, const ShadowMaps& maps) {
  constexpr int kStep = 4, kCoarse = kCells / kStep;
  cv::Mat coarse(kCoarse, kCoarse, CV_32FC1), light;
  const double middle = 0.5 * (kCoarse - 1);
  tbb::parallel_for(0, kCoarse, [&](int row) {
    for (int column = 0; column < kCoarse; ++column) {
      const Eigen::Vector3f p(static_cast<float>(grid.from_x + kCell * (kStep * (column + 0.5) - 0.5)),
                              static_cast<float>(grid.from_y + kCell * (kStep * (row + 0.5) - 0.5)), 0.0F);
      const double out = std::max(std::abs(row - middle), std::abs(column - middle)) / middle;
      const auto share = static_cast<float>(std::clamp((1.0 - out) / 0.3, 0.0, 1.0));
      coarse.at<float>(row, column) = 1.0F - share * (1.0F - floor_light(p, maps.at(p, Eigen::Vector3f::UnitZ())));
    }
  });
  cv::resize(coarse, light, {kCells, kCells}, 0, 0, cv::INTER_LINEAR);
  cv::GaussianBlur(light, light, {}, 2.5);
  return light;
}

}  // namespace

BackdropOptions room_around(const std::vector<capture::CameraModel>& cameras, BackdropOptions options) {
  constexpr double kBehindCamera = 0.7;  // metres
  for (const auto& camera : cameras)
    options.wall_radius = std::max(options.wall_radius, camera.centre().head<2>().norm() + kBehindCamera);
  return options;
}

Backdrop make_backdrop(const capture::CameraModel& camera, const BackdropOptions& options) {
  const PaintedRoom room(options);
  const Eigen::Vector3d eye = camera.centre();
  Backdrop backdrop{cv::Mat(camera.height, camera.width, CV_32FC3, cv::Scalar::all(0.0)),
                    cv::Mat(camera.height, camera.width, CV_32FC2, cv::Scalar::all(kNoFloor))};
  if (options.paint == ScreenPaint::green) backdrop.fading = {2, 0, 1};
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = capture::ray_through(camera, {x, y});
      if (!ray) continue;  // beyond the lens's field
      const auto seen = room.seen_along(eye, *ray, 1.0 / camera.K(1, 1));
      for (int c = 0; c < 3; ++c) backdrop.linear.at<cv::Vec3f>(y, x)[c] = seen.linear[c];
      if (seen.is_floor)
        backdrop.floor.at<cv::Vec2f>(y, x) = {static_cast<float>(seen.point.x()), static_cast<float>(seen.point.y())};
    }
  });
  return backdrop;
}

float ContactShadow::at(float x, float y) const {
  const auto column = static_cast<float>((x - from_x) / cell), row = static_cast<float>((y - from_y) / cell);
  if (!(column >= 0.0F && row >= 0.0F && column < static_cast<float>(light.cols - 1) &&
        row < static_cast<float>(light.rows - 1)))
    return 1.0F;
  const int i = static_cast<int>(column), j = static_cast<int>(row);
  const float u = column - static_cast<float>(i), v = row - static_cast<float>(j);
  const float* upper = light.ptr<float>(j) + i;
  const float* lower = light.ptr<float>(j + 1) + i;
  return (1.0F - v) * ((1.0F - u) * upper[0] + u * upper[1]) + v * ((1.0F - u) * lower[0] + u * lower[1]);
}

ContactShadow contact_shadow(const std::vector<recon::TriangleMesh>& surfaces, const ShadowMaps& maps) {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  const auto& performer = surfaces.front();
  for (const auto& p : performer.positions) middle += p / static_cast<float>(performer.positions.size());
  ContactShadow shadow;
  shadow.cell = kCell;
  shadow.from_x = static_cast<double>(middle.x()) - 0.5 * kCell * kCells;
  shadow.from_y = static_cast<double>(middle.y()) - 0.5 * kCell * kCells;
  cv::Mat depth(kCells, kCells, CV_32FC1, cv::Scalar(0)), blurred;
  const auto cover = cover_of(surfaces, shadow);
  for (std::size_t i = 0; i < cover.size(); ++i) {
    cv::GaussianBlur(cover[i], blurred, {}, kLayers[i].spread / kCell, 0, cv::BORDER_CONSTANT);
    depth += kLayers[i].strength * cv::min(blurred, 1.2);
  }
  cv::exp(-depth, shadow.light);
  shadow.light = shadow.light.mul(lamp_shadow(shadow, maps));
  return shadow;
}

void lay_shadow(const Backdrop& backdrop, const ContactShadow& shadow, cv::Mat& picture) {
  tbb::parallel_for(tbb::blocked_range<int>(0, picture.rows, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const auto* floor = backdrop.floor.ptr<cv::Vec2f>(y);
      auto* pixel = picture.ptr<cv::Vec3f>(y);
      for (int x = 0; x < picture.cols; ++x) {
        if (floor[x][0] == kNoFloor) continue;
        const float light = shadow.at(floor[x][0], floor[x][1]);
        if (light >= 0.999F) continue;
        const float fourth = std::sqrt(std::sqrt(light));
        const std::array<float, 3> powers{1.0F, std::sqrt(fourth), fourth};
        for (int c = 0; c < 3; ++c) pixel[x][c] *= light * powers[backdrop.fading[static_cast<std::size_t>(c)]];
      }
    }
  });
}

}  // namespace rotunda::simulator
