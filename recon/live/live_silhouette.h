#pragma once
// One camera with its signed silhouette at live quality: hull/silhouette_view.h at half the picture's size or less, of
// the performer's box alone, in single precision. World frame and units; pixels are those of the reduced picture.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "capture/camera_model.h"

namespace rotunda::recon {

// Where a camera sees a point.
struct LivePixel {
  float x = 0.0F, y = 0.0F;  // pixels
  float depth = 0.0F;        // along the camera's axis, world units
};

// A camera whose pixels are `reduction` x `reduction` of `camera`'s; odd ones at the right and below are left out.
capture::CameraModel reduced_camera(capture::CameraModel camera, int reduction);

class LiveSilhouette {
 public:
  static constexpr int kMargin = 6;  // pixels about the performer that `box()` has

  // `camera`: of half the picture's size; `alpha`: CV_8UC1, of `box` in that half, nobody outside of it, empty if there
  // is nobody at all. `reduction`: how many pixels a side of that half become one.
  LiveSilhouette(const capture::CameraModel& camera, const cv::Mat& alpha, const cv::Rect& box, int reduction);

  const capture::CameraModel& camera() const { return camera_; }
  bool is_empty() const { return is_empty_; }
  bool is_full() const { return is_full_; }  // nothing but performer
  float focal() const { return focal_; }     // pixels

  // Signed distance to the outline, positive inside, where `box()` has it.
  const cv::Mat& distance_px() const { return distance_; }  // CV_32FC1
  const cv::Rect& box() const { return box_; }

  // False where the camera does not see: behind it or outside of its picture.
  bool project(const Eigen::Vector3f& point, LivePixel& pixel) const { return see(rotation_ * point + shift_, pixel); }
  // The same of a point in the camera's frame.
  bool see(const Eigen::Vector3f& p, LivePixel& pixel) const;

  // Pixels; far outside only no more than it is, in size.
  float distance_at(float x, float y) const;
  float distance_at(const LivePixel& pixel) const { return distance_at(pixel.x, pixel.y); }

  const Eigen::Matrix3f& rotation() const { return rotation_; }
  const Eigen::Vector3f& shift() const { return shift_; }
  float most_px_per_ideal() const { return most_px_per_ideal_; }  // no way in the ideal plane is longer in the picture

  // What the view says of a whole ball of the world; conservative.
  struct BallSight {
    bool may_be_seen = true;
    bool is_outside = false;  // wholly seen, and nowhere inside the silhouette
    bool is_inside = false;   // wholly seen, and nowhere outside of it
    float distance = 0.0F;    // of its centre from the outline, world units; of a ball that is wholly seen
  };
  BallSight ball(const Eigen::Vector3f& centre, float radius) const;

 private:
  Eigen::Vector2f distorted(float u, float v, float r2) const;

  capture::CameraModel camera_;
  cv::Mat distance_;
  cv::Rect box_;
  bool is_empty_ = true, is_full_ = false, is_distorted_ = false;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f shift_;
  float fx_ = 1.0F, fy_ = 1.0F, skew_ = 0.0F, cx_ = 0.0F, cy_ = 0.0F, focal_ = 1.0F;
  float k1_ = 0.0F, k2_ = 0.0F, k3_ = 0.0F, p1_ = 0.0F, p2_ = 0.0F;
  float farthest_ideal2_ = 0.0F;       // squared radius of the picture on the ideal image plane
  float right_ = 0.0F, below_ = 0.0F;  // the picture's last edges
  float most_px_per_ideal_ = 1.0F;
};

inline Eigen::Vector2f LiveSilhouette::distorted(float u, float v, float r2) const {
  if (!is_distorted_) return {u, v};
  const float radial = 1.0F + r2 * (k1_ + r2 * (k2_ + r2 * k3_));
  return {u * radial + 2.0F * p1_ * u * v + p2_ * (r2 + 2.0F * u * u),
          v * radial + p1_ * (r2 + 2.0F * v * v) + 2.0F * p2_ * u * v};
}

inline bool LiveSilhouette::see(const Eigen::Vector3f& p, LivePixel& pixel) const {
  if (p.z() <= 0.0F) return false;
  const float inverse = 1.0F / p.z(), u = p.x() * inverse, v = p.y() * inverse, r2 = u * u + v * v;
  if (r2 > farthest_ideal2_) return false;
  const Eigen::Vector2f image = distorted(u, v, r2);
  pixel = {fx_ * image.x() + skew_ * image.y() + cx_, fy_ * image.y() + cy_, p.z()};
  return pixel.x >= -0.5F && pixel.y >= -0.5F && pixel.x <= right_ && pixel.y <= below_;
}

inline float LiveSilhouette::distance_at(float x, float y) const {
  x -= static_cast<float>(box_.x);
  y -= static_cast<float>(box_.y);
  const auto right = static_cast<float>(box_.width - 1), below = static_cast<float>(box_.height - 1);
  const float beyond = std::max({-x, -y, x - right, y - below});
  if (beyond > 0.5F) return -beyond - kMargin;
  const float inner_x = std::clamp(x, 0.0F, right - 0.001F), inner_y = std::clamp(y, 0.0F, below - 0.001F);
  const int x0 = static_cast<int>(inner_x), y0 = static_cast<int>(inner_y);
  const float along = inner_x - static_cast<float>(x0), down = inner_y - static_cast<float>(y0);
  const auto* row = distance_.ptr<float>(y0) + x0;
  const auto* next = distance_.ptr<float>(y0 + 1) + x0;
  const float top = row[0] + along * (row[1] - row[0]), bottom = next[0] + along * (next[1] - next[0]);
  return top + down * (bottom - top);
}

}  // namespace rotunda::recon
