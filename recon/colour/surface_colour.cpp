#include "recon/colour/surface_colour.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/matte/despill.h"
#include "capture/srgb.h"
#include "config/errors.h"
#include "recon/colour/rim.h"
#include "recon/colour/visibility.h"

namespace rotunda::recon {
namespace {

// A view whose weight is nothing but rim still counts where no other view has any: thin parts are all rim.
constexpr double kRimWeight = 1e-3;
constexpr double kSteepest = 5.0;  // tangent of the slope a depth difference between neighbours is excused by

struct PreparedView {
  const capture::CameraModel* camera = nullptr;
  Eigen::Vector3d centre;
  double focal_px = 1.0;
  cv::Mat rgb;             // without spill
  cv::Mat depth_in_matte;  // CV_32FC1: pixels from the outline inwards
  DepthMap surface;
};

void check(const ColourView& view) {
  const cv::Size size(view.camera.width, view.camera.height);
  if (view.rgb.size() != size || view.rgb.type() != CV_8UC3 || view.matte.alpha.size() != size ||
      view.matte.alpha.type() != CV_8UC1 || (!view.clean.empty() && view.clean.size() != size))
    throw InvalidInput(fmt::format(
        "{}: picture ({} x {}) and matte ({} x {}) must be of the calibration's size, {} x {}", view.camera.name,
        view.rgb.cols, view.rgb.rows, view.matte.alpha.cols, view.matte.alpha.rows, size.width, size.height));
}

cv::Mat without_spill(const ColourView& view, const SurfaceColourOptions& options) {
  if (!view.clean.empty()) return view.clean;
  return options.remove_spill ? capture::despilled(view.rgb, view.matte, options.backdrop) : view.rgb;
}

PreparedView prepare(const ColourView& view, const TriangleMesh& occluder, const SurfaceColourOptions& options) {
  PreparedView prepared;
  prepared.camera = &view.camera;
  prepared.centre = view.camera.centre();
  prepared.focal_px = std::sqrt(std::abs(view.camera.K(0, 0) * view.camera.K(1, 1)));
  prepared.depth_in_matte = depth_inside(view.matte);
  prepared.rgb = rim_from_inside(without_spill(view, options), prepared.depth_in_matte);
  if (view.colour != Eigen::Matrix3d::Identity()) prepared.rgb = capture::with_matrix(prepared.rgb, view.colour);
  prepared.surface = render_depth(occluder, view.camera, options.depth_downscale);
  return prepared;
}

template <class Pixel>
Pixel bilinear(const cv::Mat& image, const Eigen::Vector2d& place) {
  const int x = std::clamp(static_cast<int>(place.x()), 0, std::max(0, image.cols - 2));
  const int y = std::clamp(static_cast<int>(place.y()), 0, std::max(0, image.rows - 2));
  const int right = std::min(x + 1, image.cols - 1), below = std::min(y + 1, image.rows - 1);
  const float u = std::clamp(static_cast<float>(place.x()) - static_cast<float>(x), 0.0F, 1.0F);
  const float v = std::clamp(static_cast<float>(place.y()) - static_cast<float>(y), 0.0F, 1.0F);
  using Source = std::conditional_t<std::is_same_v<Pixel, float>, float, cv::Vec3b>;
  const Pixel top = Pixel(image.at<Source>(y, x)) * (1.0F - u) + Pixel(image.at<Source>(y, right)) * u;
  const Pixel bottom = Pixel(image.at<Source>(below, x)) * (1.0F - u) + Pixel(image.at<Source>(below, right)) * u;
  return top * (1.0F - v) + bottom * v;
}

// How much of the depth map's 3 x 3 pixels about the place shows the surface at this depth: 0 for a point that is
// hidden or so near to what hides it that its pixels mix both, less than 1 beside a drop to what lies behind. What lies
// beyond the surface's outline is the matte's to judge.
double share_seen(const DepthMap& map, const Eigen::Vector2d& place, double depth, double footprint, double slope,
                  double tolerance_px) {
  const int x = static_cast<int>(std::lround(map.from_picture(place.x())));
  const int y = static_cast<int>(std::lround(map.from_picture(place.y())));
  const double tolerance = footprint * (tolerance_px + 1.5 * map.downscale * slope);
  int seen = 0, judged = 0;
  for (int j = std::max(0, y - 1); j <= std::min(map.depth.rows - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(map.depth.cols - 1, x + 1); ++i) {
      const double nearest = map.depth.at<float>(j, i);
      if (nearest < depth - tolerance) return 0.0;
      if (!std::isfinite(nearest)) continue;
      ++judged;
      seen += nearest <= depth + tolerance;
    }
  return judged == 0 ? 1.0 : static_cast<double>(seen) / judged;
}

struct Sample {
  double weight = 0.0;
  cv::Vec3f colour;
};

Sample sample_of(const PreparedView& view, const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                 const SurfaceColourOptions& options) {
  const Eigen::Vector3d towards = view.centre - point;
  const double cosine = normal.dot(towards.normalized());
  if (!(cosine >= options.least_cosine)) return {};
  const auto place = capture::project(*view.camera, point);
  if (!place || !(place->x() >= 0.0 && place->y() >= 0.0 && place->x() <= view.camera->width - 1 &&
                  place->y() <= view.camera->height - 1))
    return {};
  const double inside = bilinear<float>(view.depth_in_matte, *place);
  if (inside <= 0.0) return {};
  const double depth = view.camera->R.row(2).dot(point) + view.camera->t.z();
  const double slope = std::min(kSteepest, std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine);
  const double seen = share_seen(view.surface, *place, depth, depth / view.focal_px, slope, options.depth_tolerance_px);
  if (seen == 0.0) return {};
  const double feather = std::max(kRimWeight, outline_weight(inside, options.feather_px) * seen);
  return {std::pow(cosine, options.cosine_power) * feather, bilinear<cv::Vec3f>(view.rgb, *place)};
}

}  // namespace

SurfaceColour surface_colour(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> normals,
                             const TriangleMesh& occluder, std::span<const ColourView> views,
                             const SurfaceColourOptions& options) {
  if (points.size() != normals.size())
    throw InvalidInput(fmt::format("{} points but {} normals to colour", points.size(), normals.size()));
  for (const auto& view : views) check(view);
  std::vector<PreparedView> prepared(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t i) { prepared[i] = prepare(views[i], occluder, options); });

  SurfaceColour result{std::vector<Colour>(points.size(), Colour{}), std::vector<std::uint8_t>(points.size(), 0)};
  const auto colour_point = [&](std::size_t i) {
    double weight = 0.0;
    cv::Vec3d sum;
    for (const auto& view : prepared) {
      const Sample sample = sample_of(view, points[i].cast<double>(), normals[i].cast<double>(), options);
      weight += sample.weight;
      sum += cv::Vec3d(sample.colour) * sample.weight;
    }
    if (weight <= 0.0) return;
    for (int c = 0; c < 3; ++c)
      result.colours[i][static_cast<std::size_t>(c)] = cv::saturate_cast<std::uint8_t>(sum[c] / weight);
    result.coverage[i] = 255;
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) colour_point(i);
  });
  return result;
}

}  // namespace rotunda::recon
