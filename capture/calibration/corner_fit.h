#pragma once
// Where a corner of the board lies in a picture, by least squares between the picture and the print itself: the print
// is projected about the corner, averaged over each pixel, blurred, and moved until it fits (gain, offset and slope of
// the light are free). Markers beside the corner are part of what is fitted, so they do not pull; light is compared
// linearly, so that dark and bright edges weigh the same.
#include <optional>
#include <span>
#include <vector>

#include "capture/calibration/board_print.h"

namespace rotunda::capture {

// CV_8UC1 or CV_16UC1 grey on the sRGB curve to CV_32FC1 linear light, 0 to 1. Throws InvalidInput for other types.
cv::Mat linear_light(const cv::Mat& grey);

struct CornerFitOptions {
  double blur_px = 0.8;        // standard deviation of the picture's point spread
  double window = 0.42;        // half side of what is compared, squares
  double largest_radius = 14;  // of it, pixels: beyond, it adds time and no accuracy
  double reach_px = 2.5;       // how far the corner may be from where it is expected
  double least_correlation = 0.85;
};

struct CornerFit {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double deviation = 0.0;    // standard deviation a axis by the fit's residuals, pixels
  double correlation = 0.0;  // of print and picture, 1: the same
  double contrast = 0.0;     // white minus black, linear light
};

// `image_from_board`: a homography, metres to pixels, that holds about the corner; its shift is what is corrected.
// Nothing if the window leaves the picture, is too small, does not look like the print, or the corner is out of reach.
std::optional<CornerFit> fit_corner(const cv::Mat& linear, const BoardPrint& print, const Eigen::Vector2d& corner,
                                    const Eigen::Matrix3d& image_from_board, const CornerFitOptions& options);

// How much print and picture look alike with each of these blurs, the corner being where it fits with that of the
// options; empty if it does not fit.
std::vector<double> correlation_at_blurs(const cv::Mat& linear, const BoardPrint& print, const Eigen::Vector2d& corner,
                                         const Eigen::Matrix3d& image_from_board, const CornerFitOptions& options,
                                         std::span<const double> blurs_px);

}  // namespace rotunda::capture
