#include "recon/live/live_silhouette.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "recon/hull/lens_bounds.h"
#include "recon/hull/signed_silhouette.h"

namespace rotunda::recon {
namespace {

constexpr int kMargin = LiveSilhouette::kMargin;

// The part of a picture of `size`, reduced, that `box` takes up, and what is around it.
struct Crop {
  cv::Mat alpha;
  cv::Rect box;
};
Crop reduced_crop(const cv::Mat& alpha, const cv::Rect& box, cv::Size size, int reduction) {
  const int left = box.x / reduction - kMargin, top = box.y / reduction - kMargin;
  const int right = (box.br().x + reduction - 1) / reduction + kMargin;
  const int below = (box.br().y + reduction - 1) / reduction + kMargin;
  Crop crop{{}, cv::Rect(left, top, right - left, below - top) & cv::Rect({}, size)};
  const cv::Rect wide(crop.box.x * reduction, crop.box.y * reduction, crop.box.width * reduction,
                      crop.box.height * reduction);
  cv::Mat whole(wide.size(), CV_8UC1, cv::Scalar(0));
  const cv::Rect both = wide & box;
  if (!both.empty()) alpha(both - box.tl()).copyTo(whole(both - wide.tl()));
  if (reduction == 1)
    crop.alpha = whole;
  else
    cv::resize(whole, crop.alpha, crop.box.size(), 0, 0, cv::INTER_AREA);
  return crop;
}

}  // namespace

capture::CameraModel reduced_camera(capture::CameraModel camera, int reduction) {
  camera.width /= reduction;
  camera.height /= reduction;
  camera.K.topRows<2>() /= reduction;
  for (int row = 0; row < 2; ++row) camera.K(row, 2) += 0.5 / reduction - 0.5;
  return camera;
}

LiveSilhouette::LiveSilhouette(const capture::CameraModel& camera, const cv::Mat& alpha, const cv::Rect& box,
                               int reduction)
    : camera_(reduced_camera(camera, reduction)),
      rotation_(camera.R.cast<float>()),
      shift_(camera.t.cast<float>()),
      right_(static_cast<float>(camera_.width) - 0.5F),
      below_(static_cast<float>(camera_.height) - 0.5F) {
  const Eigen::Matrix3f K = camera_.K.cast<float>();
  fx_ = K(0, 0), skew_ = K(0, 1), cx_ = K(0, 2), fy_ = K(1, 1), cy_ = K(1, 2);
  focal_ = std::sqrt(std::abs(fx_ * fy_));
  const Eigen::Matrix<float, 5, 1> d = camera.distortion.cast<float>();
  k1_ = d[0], k2_ = d[1], p1_ = d[2], p2_ = d[3], k3_ = d[4];
  is_distorted_ = !camera.distortion.isZero(0.0);
  const double radius = picture_radius(camera_);
  farthest_ideal2_ = static_cast<float>(radius * radius * (1.0 + 1e-5));
  most_px_per_ideal_ = std::max(std::abs(fx_), std::abs(fy_)) + std::abs(skew_);
  if (is_distorted_) most_px_per_ideal_ *= static_cast<float>(largest_stretch(camera_, radius));
  if (alpha.empty()) return;
  auto crop = reduced_crop(alpha, box, {camera_.width, camera_.height}, reduction);
  if (crop.box.width < 2 || crop.box.height < 2) return;
  box_ = crop.box;
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(crop.alpha, &least, &most);
  is_empty_ = most < 127.5;
  is_full_ = least > 127.5 && box_.size() == cv::Size(camera_.width, camera_.height);
  distance_ = quick_silhouette({crop.alpha});
}

LiveSilhouette::BallSight LiveSilhouette::ball(const Eigen::Vector3f& centre, float radius) const {
  const Eigen::Vector3f p = rotation_ * centre + shift_;
  if (p.z() + radius <= 0.0F) return {.may_be_seen = false};
  if (p.z() - radius <= 0.05F * radius) return {};
  const float u = p.x() / p.z(), v = p.y() / p.z(), r2 = u * u + v * v;
  const float spread = radius * std::sqrt(1.0F + r2) / (p.z() - radius);  // bounds |q - (u, v)| in the ball
  const float ideal = std::sqrt(r2), farthest = std::sqrt(farthest_ideal2_);
  if (ideal - spread > farthest) return {.may_be_seen = false};
  if (is_distorted_ && ideal + spread > 1.2F * farthest) return {};
  const Eigen::Vector2f image = distorted(u, v, r2);
  const float x = fx_ * image.x() + skew_ * image.y() + cx_, y = fy_ * image.y() + cy_;
  const float spread_px = spread * most_px_per_ideal_;
  if (x + spread_px < -0.5F || y + spread_px < -0.5F || x - spread_px > right_ || y - spread_px > below_)
    return {.may_be_seen = false};
  if (x < spread_px || y < spread_px || x + spread_px > right_ - 0.5F || y + spread_px > below_ - 0.5F) return {};
  constexpr float kSlack = 2.0F;     // pixels: interpolation, and the step at the edge of the exact band
  constexpr float kChamfer = 0.98F;  // what is left of a distance if its mistake is largest
  const float distance = kChamfer * distance_at(x, y);
  return {.may_be_seen = true,
          .is_outside = distance + spread_px<-kSlack, .is_inside = distance - spread_px> kSlack,
          .distance = distance * p.z() / focal_};
}

}  // namespace rotunda::recon
