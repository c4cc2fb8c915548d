#include "recon/hull/lost_parts.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "recon/hull/signed_silhouette.h"
#include "recon/hull/visual_hull.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kFewestViews = 5;
constexpr int kMostDenying = 2;
constexpr double kOutlineSlack = 2.0;  // pixels beside an outline that are not held against a hull
constexpr double kHalfDiagonal = 0.87;

enum class Sight : std::uint8_t { unseen, holds, touches, denies };

struct Place {
  Eigen::Vector3d centre;
  std::vector<Sight> sights;  // by view
  int denying = 0;
  bool is_lost = false;
};

std::vector<Place> places_in(std::span<const SilhouetteView> views, const LostPartsOptions& options) {
  const double size = options.cube_size;
  const VisualHullOptions search{
      .bounds = options.bounds, .cell_size = size, .min_views = 2, .tolerate_misses = kMostDenying};
  const auto cubes = occupied_cubes(views, options.bounds, size, search);
  std::vector<Place> places(cubes.size());
  tbb::parallel_for(std::size_t{0}, cubes.size(), [&](std::size_t i) {
    auto& place = places[i];
    place.centre = options.bounds.min() + size * (cubes[i].cast<double>() + Eigen::Vector3d::Constant(0.5));
    for (const auto& view : views) {
      const auto distance = view.distance(place.centre);
      const double depth = distance ? static_cast<double>(*distance) : 0.0;
      place.sights.push_back(!distance                        ? Sight::unseen
                             : depth >= 0.0                   ? Sight::holds
                             : depth >= -kHalfDiagonal * size ? Sight::touches
                                                              : Sight::denies);
      place.denying += place.sights.back() == Sight::denies ? 1 : 0;
    }
  });
  return places;
}

// The picture's pixels that may show a cube: a square around its centre.
std::optional<cv::Rect> footprint(const capture::CameraModel& camera, const Eigen::Vector3d& centre, double cube_size) {
  const auto pixel = capture::project(camera, centre);
  if (!pixel) return std::nullopt;
  const double depth = camera.R.row(2).dot(centre) + camera.t.z();
  const double focal = std::max(std::abs(camera.K(0, 0)), std::abs(camera.K(1, 1)));
  const double reach = std::min(kHalfDiagonal * cube_size * focal / depth, 1.0 * camera.width + camera.height);
  const cv::Rect square(cvFloor(pixel->x() - reach), cvFloor(pixel->y() - reach), 2 * cvCeil(reach) + 1,
                        2 * cvCeil(reach) + 1);
  return square & cv::Rect(0, 0, camera.width, camera.height);
}

// The silhouette behind which nothing stands that a view holds or may hold: CV_8UC1, 255 there.
cv::Mat unexplained(const SilhouetteView& view, std::span<const Place> places, double cube_size) {
  cv::Mat mask = view.distance_px() > kOutlineSlack;
  for (const auto& place : places)
    if (place.denying == 0 || place.is_lost)
      if (const auto square = footprint(view.camera(), place.centre, cube_size)) mask(*square).setTo(0);
  return mask;
}

bool is_witness(const SilhouetteView& view, const cv::Mat& unexplained, const Eigen::Vector3d& centre) {
  const auto pixel = capture::project(view.camera(), centre);
  if (!pixel) return false;
  const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
  return x >= 0 && y >= 0 && x < unexplained.cols && y < unexplained.rows && unexplained.at<std::uint8_t>(y, x) != 0;
}

bool has_witnesses(std::span<const SilhouetteView> views, std::span<const cv::Mat> unexplained, const Place& place) {
  int witnesses = 0;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (place.sights[i] == Sight::holds && is_witness(views[i], unexplained[i], place.centre)) ++witnesses;
  return witnesses > 2 * place.denying;
}

// Marks what is lost, first where one view denies it: what that explains needs no second one to be wrong.
bool find_lost(std::span<const SilhouetteView> views, std::vector<Place>& places, double cube_size) {
  bool any = false;
  for (int denying = 1; denying <= kMostDenying; ++denying) {
    std::vector<cv::Mat> open(views.size());
    tbb::parallel_for(std::size_t{0}, views.size(),
                      [&](std::size_t i) { open[i] = unexplained(views[i], places, cube_size); });
    for (auto& place : places) {
      if (place.denying != denying || !has_witnesses(views, open, place)) continue;
      place.is_lost = any = true;
    }
  }
  return any;
}

// Where the view denies what is lost: CV_8UC1, 255 there.
cv::Mat lost_to(const SilhouetteView& view, std::size_t index, std::span<const Place> places, double cube_size) {
  cv::Mat part = cv::Mat::zeros(view.distance_px().size(), CV_8UC1);
  for (const auto& place : places)
    if (place.is_lost && place.sights[index] == Sight::denies)
      if (const auto square = footprint(view.camera(), place.centre, cube_size)) part(*square).setTo(255);
  return part;
}

}  // namespace

LostParts put_back_lost_parts(std::span<const SilhouetteView> views, const LostPartsOptions& options) {
  LostParts result{{views.begin(), views.end()}, std::vector<double>(views.size(), 0.0)};
  if (views.size() < kFewestViews) return result;
  auto places = places_in(views, options);
  if (!find_lost(views, places, options.cube_size)) return result;
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    const cv::Mat part = lost_to(views[i], i, places, options.cube_size);
    const int added = cv::countNonZero(part & (views[i].distance_px() <= 0.0F));
    if (added == 0) return;
    result.share[i] = static_cast<double>(added) / std::max(1, cv::countNonZero(views[i].distance_px() > 0.0F));
    result.views[i] = views[i].joined_with({part});
  });
  return result;
}

}  // namespace rotunda::recon
