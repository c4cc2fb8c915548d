#include "recon/hull/silhouette_view.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/hull/lens_bounds.h"
#include "recon/hull/signed_silhouette.h"

namespace rotunda::recon {
namespace {

struct PixelSample {
  double value, dx, dy;  // pixels; gradient in pixels a pixel
};

// Bilinear; the half pixel around the outermost centres repeats them.
PixelSample sample(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const double x = std::clamp(pixel.x(), 0.0, image.cols - 1.001), y = std::clamp(pixel.y(), 0.0, image.rows - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double fx = x - x0, fy = y - y0;
  const auto* row = image.ptr<float>(y0) + x0;
  const auto* below = image.ptr<float>(y0 + 1) + x0;
  const double a = static_cast<double>(row[0]), b = static_cast<double>(row[1]);
  const double c = static_cast<double>(below[0]), d = static_cast<double>(below[1]);
  const double top = a + fx * (b - a), bottom = c + fx * (d - c);
  return {top + fy * (bottom - top), (1.0 - fy) * (b - a) + fy * (d - c), (1.0 - fx) * (c - a) + fx * (d - b)};
}

bool in_picture(const capture::CameraModel& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= camera.width - 0.5 && pixel.y() <= camera.height - 0.5;
}

}  // namespace

SilhouetteView::SilhouetteView(const capture::CameraModel& camera, const capture::Matte& matte) : camera_(camera) {
  if (matte.alpha.cols != camera.width || matte.alpha.rows != camera.height || camera.width < 2 || camera.height < 2)
    throw InvalidInput(fmt::format("{}: the matte has {} x {} pixels, the calibration says {} x {}", camera.name,
                                   matte.alpha.cols, matte.alpha.rows, camera.width, camera.height));
  distance_ = signed_silhouette(matte);
  is_empty_ = recon::is_empty(matte);
  distorted_ = !camera.distortion.isZero(0.0);
  max_ideal_radius_ = picture_radius(camera);
  if (distorted_) max_stretch_ = largest_stretch(camera, max_ideal_radius_);
}

SilhouetteView SilhouetteView::joined_with(const capture::Matte& guess) const {
  SilhouetteView joined = *this;
  cv::Mat added;
  cv::max(distance_, signed_silhouette(guess), joined.distance_);
  cv::dilate((joined.distance_ > 0.0F) & (distance_ <= 0.0F), added, cv::Mat::ones(3, 3, CV_8UC1));
  joined.guess_ = guess_.empty() ? added : cv::Mat(added | guess_);
  joined.is_empty_ = is_empty_ && recon::is_empty(guess);
  return joined;
}

bool SilhouetteView::is_guessed(const Eigen::Vector2d& pixel) const {
  if (guess_.empty()) return false;
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, guess_.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, guess_.rows - 1);
  return guess_.at<std::uint8_t>(y, x) != 0;
}

std::optional<float> SilhouetteView::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = camera_.R * point + camera_.t;
  if (p.z() <= 0.0) return std::nullopt;
  const Eigen::Vector2d ideal = p.head<2>() / p.z();
  if (ideal.squaredNorm() > max_ideal_radius_ * max_ideal_radius_) return std::nullopt;
  const Eigen::Matrix2d pixel_from_ideal = camera_.K.topLeftCorner<2, 2>();
  const Eigen::Vector2d image = distorted_ ? capture::distort(camera_, ideal) : ideal;
  const Eigen::Vector2d pixel = pixel_from_ideal * image + camera_.K.topRightCorner<2, 1>();
  if (!in_picture(camera_, pixel)) return std::nullopt;
  const auto s = sample(distance_, pixel);
  // d pixel / d point = A [I | -ideal] / z; pixels a metre along the silhouette's normal is the norm of g^T of that.
  Eigen::Vector2d normal(s.dx, s.dy);
  const double steepness = normal.squaredNorm();
  if (steepness < 0.25)
    return static_cast<float>(s.value * p.z() / std::sqrt(std::abs(pixel_from_ideal.determinant())));
  const Eigen::Vector2d g = pixel_from_ideal.transpose() * normal;
  const double along_ray = g.dot(ideal);
  const double pixels_per_metre = std::sqrt((g.squaredNorm() + along_ray * along_ray) / steepness) / p.z();
  return static_cast<float>(s.value / pixels_per_metre);
}

double SilhouetteView::most_px_per_ideal() const {
  const double focal = std::max(std::abs(camera_.K(0, 0)), std::abs(camera_.K(1, 1))) + std::abs(camera_.K(0, 1));
  return focal * max_stretch_;
}

SilhouetteView::BallSight SilhouetteView::ball(const Eigen::Vector3d& centre, double radius) const {
  const Eigen::Vector3d p = camera_.R * centre + camera_.t;
  if (p.z() + radius <= 0.0) return {false, false};
  if (p.z() - radius <= 0.05 * radius) return {};
  const Eigen::Vector2d ideal = p.head<2>() / p.z();
  const double spread = radius * std::sqrt(1.0 + ideal.squaredNorm()) / (p.z() - radius);  // bounds |q - ideal| in it
  if (ideal.norm() - spread > max_ideal_radius_) return {false, false};
  if (distorted_ && ideal.norm() + spread > max_ideal_radius_ * 1.2) return {};
  const Eigen::Vector2d pixel =
      camera_.K.topLeftCorner<2, 2>() * (distorted_ ? capture::distort(camera_, ideal) : ideal) +
      camera_.K.topRightCorner<2, 1>();
  const double spread_px = spread * most_px_per_ideal();
  if (pixel.x() + spread_px < -0.5 || pixel.y() + spread_px < -0.5 || pixel.x() - spread_px > camera_.width - 0.5 ||
      pixel.y() - spread_px > camera_.height - 0.5)
    return {false, false};
  const bool wholly_seen = pixel.x() - spread_px >= 0.0 && pixel.y() - spread_px >= 0.0 &&
                           pixel.x() + spread_px <= camera_.width - 1.0 &&
                           pixel.y() + spread_px <= camera_.height - 1.0;
  constexpr double kSlack = 2.0;  // pixels: interpolation, and the step at the edge of the exact band
  return {true, wholly_seen && sample(distance_, pixel).value + spread_px < -kSlack};
}

std::vector<SilhouetteView> silhouette_views(std::span<const capture::CameraModel> cameras,
                                             std::span<const capture::Matte> mattes) {
  if (cameras.size() != mattes.size())
    throw InvalidInput(fmt::format("{} cameras but {} mattes: one a camera is needed", cameras.size(), mattes.size()));
  if (cameras.size() < 2) throw InvalidInput("a visual hull needs at least two views");
  std::vector<std::optional<SilhouetteView>> built(cameras.size());
  tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t i) { built[i].emplace(cameras[i], mattes[i]); });
  std::vector<SilhouetteView> views;
  views.reserve(cameras.size());
  for (auto& view : built) views.push_back(std::move(*view));
  return views;
}

}  // namespace rotunda::recon
