#include "capture/calibration/camera_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kFeatures = 120;        // sought
constexpr int kHalfPatch = 8;         // pixels
constexpr int kReach = 32;            // pixels a feature may have moved
constexpr double kFoundAgain = 0.85;  // correlation
constexpr double kClearly = 0.05;     // more than anywhere else nearby
constexpr double kAgree = 1.0;        // pixels from what most say
constexpr int kFewestAgreeing = 8;
constexpr double kShareAgreeing = 0.4;   // of those found again
constexpr double kLeastContrast = 4.0;   // levels, standard deviation in a patch: above the noise
constexpr double kTold = 0.33;           // pixels
constexpr double kLeastVariance = 0.01;  // squared pixels: a feature is found to a tenth of one at best

double parabola_peak(double before, double at, double after) {
  const double curvature = before - 2.0 * at + after;
  return curvature < 0.0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

bool is_empty_patch(const cv::Mat& patch) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(patch, mean, deviation);
  return deviation[0] < kLeastContrast;
}

// Where the patch about `at` is in the other picture, to a fraction of a pixel.
std::optional<cv::Point2f> found_again(const cv::Mat& before, const cv::Mat& now, const cv::Point& at) {
  const cv::Rect picture({}, before.size());
  const cv::Rect patch(at.x - kHalfPatch, at.y - kHalfPatch, 2 * kHalfPatch + 1, 2 * kHalfPatch + 1);
  const cv::Rect window =
      cv::Rect(patch.x - kReach, patch.y - kReach, patch.width + 2 * kReach, patch.height + 2 * kReach) & picture;
  if ((patch & picture) != patch || is_empty_patch(before(patch))) return std::nullopt;
  cv::Mat score;
  cv::matchTemplate(now(window), before(patch), score, cv::TM_CCOEFF_NORMED);
  cv::Point best;
  double highest = 0.0, next = 0.0;
  cv::minMaxLoc(score, nullptr, &highest, nullptr, &best);
  if (highest < kFoundAgain || best.x < 1 || best.y < 1 || best.x + 1 >= score.cols || best.y + 1 >= score.rows)
    return std::nullopt;
  const auto value = [&](int dx, int dy) { return score.at<float>(best.y + dy, best.x + dx); };
  const cv::Point2f sub(static_cast<float>(parabola_peak(value(-1, 0), value(0, 0), value(1, 0))),
                        static_cast<float>(parabola_peak(value(0, -1), value(0, 0), value(0, 1))));
  cv::Mat elsewhere = score.clone();
  cv::circle(elsewhere, best, kHalfPatch, cv::Scalar(-1.0), cv::FILLED);
  cv::minMaxLoc(elsewhere, nullptr, &next);
  if (highest - next < kClearly) return std::nullopt;  // a row of equal things
  return cv::Point2f(static_cast<float>(window.x + best.x + kHalfPatch),
                     static_cast<float>(window.y + best.y + kHalfPatch)) +
         sub;
}

std::vector<cv::Point2d> places_all_over(const cv::Size& size) {
  constexpr int kSteps = 5;
  std::vector<cv::Point2d> places;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      places.emplace_back((size.width - 1.0) * i / (kSteps - 1), (size.height - 1.0) * j / (kSteps - 1));
  return places;
}

cv::Point2d moved(const cv::Mat& affine, const cv::Point2d& p) {
  const auto along = [&](int row) {
    return affine.at<double>(row, 0) * p.x + affine.at<double>(row, 1) * p.y + affine.at<double>(row, 2);
  };
  return {along(0), along(1)};
}

double mean_shift(const cv::Mat& affine, const cv::Size& size) {
  double sum = 0.0;
  const auto places = places_all_over(size);
  for (const auto& place : places) sum += cv::norm(moved(affine, place) - place);
  return sum / static_cast<double>(places.size());
}

// Of the mean shift, from what the features disagree by: features close together say little of the far side of the
// picture. A similarity's variance at a distance d from the features' middle is that of one feature times
// 1/n + d^2 / (sum of their own squared distances), on either axis.
double deviation_of(const cv::Mat& affine, const std::vector<cv::Point2d>& from, const std::vector<cv::Point2d>& to,
                    const cv::Size& size) {
  const auto n = static_cast<double>(from.size());
  cv::Point2d middle;
  for (const auto& p : from) middle += p / n;
  double squares = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    squares += std::pow(cv::norm(moved(affine, from[i]) - to[i]), 2);
    spread += std::pow(cv::norm(from[i] - middle), 2);
  }
  const double variance = std::max(squares / (2.0 * n - 4.0), kLeastVariance);
  double sum = 0.0;
  const auto places = places_all_over(size);
  for (const auto& place : places) sum += 1.0 / n + std::pow(cv::norm(place - middle), 2) / spread;
  return std::sqrt(2.0 * variance * sum / static_cast<double>(places.size()));
}

}  // namespace

std::optional<BackgroundShift> background_shift(const cv::Mat& before, const cv::Mat& now) {
  if (before.type() != CV_8UC1 || now.type() != CV_8UC1 || before.size() != now.size())
    throw InvalidInput("backgrounds are compared as grey pictures of one size");
  std::vector<cv::Point2f> corners, from, to;
  cv::goodFeaturesToTrack(before, corners, kFeatures, 0.01, std::max(before.cols / 40.0, 4.0));
  for (const auto& corner : corners) {
    const cv::Point at(cvRound(corner.x), cvRound(corner.y));
    const auto again = found_again(before, now, at);
    if (!again) continue;
    from.emplace_back(at);
    to.push_back(*again);
  }
  if (static_cast<int>(from.size()) < kFewestAgreeing) return std::nullopt;
  cv::Mat inliers;
  const cv::Mat affine = cv::estimateAffinePartial2D(from, to, inliers, cv::RANSAC, kAgree);
  BackgroundShift shift{.features = inliers.empty() ? 0 : cv::countNonZero(inliers)};
  if (affine.empty() || shift.features < kFewestAgreeing ||
      shift.features < kShareAgreeing * static_cast<double>(from.size()))
    return std::nullopt;
  shift.shift_px = mean_shift(affine, before.size());
  shift.turn_deg = std::atan2(affine.at<double>(1, 0), affine.at<double>(0, 0)) * 180.0 / std::numbers::pi;
  std::vector<cv::Point2d> agreeing, places;
  for (int i = 0; i < inliers.rows; ++i) {
    if (inliers.at<std::uint8_t>(i) == 0) continue;
    agreeing.emplace_back(from[static_cast<std::size_t>(i)]);
    places.emplace_back(to[static_cast<std::size_t>(i)]);
  }
  shift.deviation_px = deviation_of(affine, agreeing, places, before.size());
  return shift;
}

bool has_moved(const BackgroundShift& shift) {
  return shift.shift_px > std::max(kTold, 4.0 * shift.deviation_px);
}

}  // namespace rotunda::capture
