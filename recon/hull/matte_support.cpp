#include "recon/hull/matte_support.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/signed_silhouette.h"
#include "recon/hull/silhouette_view.h"
#include "recon/hull/visual_hull.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kFewestViews = 4;
constexpr double kDisagreement = 0.25;  // of a matte's area
constexpr double kSlack = 2.0;          // pixels that the search leaves beside an outline

// Where a view may show one of the cubes: CV_8UC1, 255 there.
cv::Mat footprint(const capture::CameraModel& camera, std::span<const Eigen::Vector3d> centres, double cube_size) {
  cv::Mat mask = cv::Mat::zeros(camera.height, camera.width, CV_8UC1);
  const double focal = std::max(std::abs(camera.K(0, 0)), std::abs(camera.K(1, 1)));
  for (const auto& centre : centres) {
    const auto pixel = capture::project(camera, centre);
    if (!pixel) continue;
    const double depth = camera.R.row(2).dot(centre) + camera.t.z();
    const double reach = 0.5 * std::sqrt(3.0) * cube_size * focal / depth + kSlack;
    if (!(reach < camera.width + camera.height)) return cv::Mat(mask.size(), CV_8UC1, cv::Scalar(255));
    const auto low = [](double value) { return static_cast<int>(std::floor(std::clamp(value, -1e6, 1e6))); };
    const cv::Rect around(low(pixel->x() - reach), low(pixel->y() - reach), low(2.0 * reach) + 2, low(2.0 * reach) + 2);
    mask(around & cv::Rect({}, mask.size())).setTo(255);
  }
  return mask;
}

std::vector<Eigen::Vector3d> supported_places(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& bounds,
                                              double cube_size, int stray_views) {
  const auto cubes =
      occupied_cubes(views, bounds, cube_size,
                     {.bounds = bounds, .cell_size = cube_size, .min_views = 2, .tolerate_misses = stray_views});
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(cubes.size());
  for (const auto& cube : cubes)
    centres.push_back(bounds.min() + cube_size * (cube.cast<double>() + Eigen::Vector3d::Constant(0.5)));
  return centres;
}

}  // namespace

SupportedMattes supported_mattes(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                 const MatteSupportOptions& options) {
  const auto views = silhouette_views(cameras, mattes);
  SupportedMattes result{{mattes.begin(), mattes.end()}, std::vector<double>(mattes.size(), 0.0), {}};
  const auto with_silhouette =
      std::count_if(mattes.begin(), mattes.end(), [](const capture::Matte& matte) { return !is_empty(matte); });
  if (with_silhouette < static_cast<std::ptrdiff_t>(kFewestViews)) return result;
  const Eigen::AlignedBox3d bounds = options.bounds ? *options.bounds : capture_volume(views);
  const double cube_size = options.cube_size > 0.0 ? options.cube_size : 2.0 * default_cell_size(bounds, options.unit);
  const auto places = supported_places(views, bounds, cube_size, options.stray_views);
  tbb::parallel_for(std::size_t{0}, mattes.size(), [&](std::size_t i) {
    const cv::Mat support = footprint(cameras[i], places, cube_size);
    cv::Mat kept = cv::Mat::zeros(support.size(), CV_8UC1);
    mattes[i].alpha.copyTo(kept, support);
    const double before = cv::sum(mattes[i].alpha)[0], after = cv::sum(kept)[0];
    result.dropped[i] = before > 0.0 ? 1.0 - after / before : 0.0;
    if (result.dropped[i] <= kDisagreement) result.mattes[i].alpha = kept;
  });
  for (std::size_t i = 0; i < mattes.size(); ++i)
    if (result.dropped[i] > kDisagreement) result.disagreeing.push_back(i);
  return result;
}

}  // namespace rotunda::recon
