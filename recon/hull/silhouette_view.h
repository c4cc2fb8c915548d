#pragma once
// One camera with its signed silhouette: how far a point of the world lies inside the cone of the silhouette.
// World frame and units (metres). Skew, fx != fy, distortion and mirrored worlds (det R = -1) are all the same to it.
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"

namespace rotunda::recon {

class SilhouetteView {
 public:
  // Throws InvalidInput, naming the camera, if the matte is not of the camera's size.
  SilhouetteView(const capture::CameraModel& camera, const capture::Matte& matte);

  const capture::CameraModel& camera() const { return camera_; }
  const cv::Mat& distance_px() const { return distance_; }  // CV_32FC1, positive inside
  bool is_empty() const { return is_empty_; }               // nobody in the matte

  // The same view with more to its silhouette, of which no more is known than that the body lies within: its outline
  // is none of the body's.
  SilhouetteView joined_with(const capture::Matte& guess) const;
  bool is_guessed(const Eigen::Vector2d& pixel) const;  // of an outline point: is it of such a guess?

  // Distance to the silhouette's cone, positive inside, to first order (pixels times metres a pixel at that depth along
  // the silhouette's normal); nothing where the camera does not see: behind it or outside of its picture.
  std::optional<float> distance(const Eigen::Vector3d& point) const;

  // For walks through the picture: the ideal image plane is (x/z, y/z) in the camera's frame.
  bool is_distorted() const { return distorted_; }
  bool may_see(const Eigen::Vector2d& ideal) const {
    return ideal.squaredNorm() <= max_ideal_radius_ * max_ideal_radius_;
  }
  double most_px_per_ideal() const;  // no way in the ideal plane gets longer in the picture than by this

  // What the view says of a whole ball of the world; conservative: when in doubt it may be seen and may be inside.
  struct BallSight {
    bool may_be_seen = true;
    bool is_outside = false;  // wholly seen, and nowhere inside the silhouette
  };
  BallSight ball(const Eigen::Vector3d& centre, double radius) const;

 private:
  capture::CameraModel camera_;
  cv::Mat distance_;
  cv::Mat guess_;  // CV_8UC1, 255 where the silhouette was only guessed and beside it; or none
  bool is_empty_ = false;
  bool distorted_ = false;
  double max_ideal_radius_ = 0.0;  // of the picture, on the ideal image plane: nothing beyond it is seen
  double max_stretch_ = 1.0;       // of the distortion within that radius
};

// One view a camera. Throws InvalidInput if the spans differ in size or hold fewer than two.
std::vector<SilhouetteView> silhouette_views(std::span<const capture::CameraModel> cameras,
                                             std::span<const capture::Matte> mattes);

}  // namespace rotunda::recon
