#pragma once
// A silhouette as motion capture reads it: its outline as points with outward normals, and the signed distance to it at
// half the picture's resolution, in a window around the performer. Pixels of the full picture, positive inside.
// The picture's border is no outline: a body cut by the frame has no points there.
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "capture/matte/matte.h"

namespace rotunda::recon {

struct OutlinePoint {
  Eigen::Vector2d pixel;
  Eigen::Vector2d normal;  // unit, out of the silhouette
};

struct OutlineOptions {
  double spacing_px = 6.0;  // between points along the outline
  // Specks smaller than this share of the largest patch are no part of the performer.
  double least_patch = 0.02;
};

struct SilhouetteOutline {
  std::vector<OutlinePoint> points;
  cv::Mat distance;   // CV_32FC1, half resolution
  cv::Point origin;   // of the window, half-resolution pixels
  cv::Size picture;   // full
  double area = 0.0;  // pixels inside; 0: nobody
  cv::Rect box;       // around the silhouette, full pixels

  bool is_empty() const { return area == 0.0; }
  // Signed distance at a pixel and its gradient (towards the inside, about unit); beyond the window the distance at its
  // edge plus the way there. Nothing outside of the picture or where nobody is.
  struct Sample {
    double distance_px = 0.0;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  };
  std::optional<Sample> sample(const Eigen::Vector2d& pixel) const;
};

// Throws InvalidInput unless the matte is a CV_8UC1 of at least 8 x 8 pixels.
SilhouetteOutline silhouette_outline(const capture::Matte& matte, const OutlineOptions& options = {});

}  // namespace rotunda::recon
