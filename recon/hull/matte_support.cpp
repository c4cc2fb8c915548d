#include "recon/hull/matte_support.h"

#include <fmt/format.h>
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
constexpr int kCell = 4;                // pixels a side of what footprints are drawn with

// Where a view may show one of the cubes: CV_8UC1, 255 there; up to a cell too large.
cv::Mat footprint(const capture::CameraModel& camera, std::span<const Eigen::Vector3d> centres, double cube_size) {
  cv::Mat cells = cv::Mat::zeros((camera.height + kCell - 1) / kCell, (camera.width + kCell - 1) / kCell, CV_8UC1);
  const double focal = std::max(std::abs(camera.K(0, 0)), std::abs(camera.K(1, 1)));
  for (const auto& centre : centres) {
    const auto pixel = capture::project(camera, centre);
    if (!pixel) continue;
    const double depth = camera.R.row(2).dot(centre) + camera.t.z();
    const double reach = 0.5 * std::sqrt(3.0) * cube_size * focal / depth + kSlack;
    if (!(reach < camera.width + camera.height)) return cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(255));
    const auto cell_at = [](double value, int end) {
      return static_cast<int>(std::clamp(std::floor((value + 0.5) / kCell), -1.0, static_cast<double>(end)));
    };
    const int left = std::max(0, cell_at(pixel->x() - reach, cells.cols));
    const int right = std::min(cells.cols - 1, cell_at(pixel->x() + reach, cells.cols));
    const int top = std::max(0, cell_at(pixel->y() - reach, cells.rows));
    const int bottom = std::min(cells.rows - 1, cell_at(pixel->y() + reach, cells.rows));
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x) cells.at<std::uint8_t>(y, x) = 255;
  }
  cv::Mat mask;
  cv::resize(cells, mask, {}, kCell, kCell, cv::INTER_NEAREST);
  return mask(cv::Rect(0, 0, camera.width, camera.height));
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
  if (!options.keep.empty() && options.keep.size() != mattes.size())
    throw InvalidInput(fmt::format("{} mattes, but {} are said to stay or not", mattes.size(), options.keep.size()));
  SupportedMattes result{
      {mattes.begin(), mattes.end()}, silhouette_views(cameras, mattes), std::vector<double>(mattes.size(), 0.0), {}};
  const auto& views = result.views;
  const auto with_silhouette =
      std::count_if(mattes.begin(), mattes.end(), [](const capture::Matte& matte) { return !is_empty(matte); });
  if (with_silhouette < static_cast<std::ptrdiff_t>(kFewestViews)) return result;
  const Eigen::AlignedBox3d bounds = options.bounds ? *options.bounds : capture_volume(views);
  const double cube_size = options.cube_size > 0.0 ? options.cube_size : 3.0 * default_cell_size(bounds, options.unit);
  const auto places = supported_places(views, bounds, cube_size, options.stray_views);
  tbb::parallel_for(std::size_t{0}, mattes.size(), [&](std::size_t i) {
    const cv::Mat support = footprint(cameras[i], places, cube_size);
    cv::Mat kept = cv::Mat::zeros(support.size(), CV_8UC1);
    mattes[i].alpha.copyTo(kept, support);
    const double before = cv::sum(mattes[i].alpha)[0], after = cv::sum(kept)[0];
    result.dropped[i] = before > 0.0 ? 1.0 - after / before : 0.0;
    if (after == before || result.dropped[i] > kDisagreement || (!options.keep.empty() && options.keep[i])) return;
    result.mattes[i].alpha = kept;
    result.views[i] = SilhouetteView(cameras[i], result.mattes[i]);
  });
  for (std::size_t i = 0; i < mattes.size(); ++i)
    if (result.dropped[i] > kDisagreement) result.disagreeing.push_back(i);
  return result;
}

}  // namespace rotunda::recon
