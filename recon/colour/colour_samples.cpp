#include "recon/colour/colour_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/srgb.h"
#include "config/errors.h"
#include "recon/colour/visibility.h"

namespace rotunda::recon {
namespace {

constexpr int kDarkest = 8, kBrightest = 250;  // grey levels: beyond, noise or the end of the scale
constexpr double kDepthTolerance = 2.0;        // pixel footprints

struct SeenView {
  std::size_t camera = 0;  // in the names
  const capture::CameraModel* model = nullptr;
  const cv::Mat* rgb = nullptr;
  cv::Mat inside;  // CV_32FC1, pixels from the outline
  DepthMap depth;
  double focal_px = 1.0;
};

SeenView prepare(const FrameViews& views, std::size_t i, std::size_t camera, const TriangleMesh& surface) {
  SeenView view{.camera = camera,
                .model = &views.cameras[i],
                .rgb = &views.pictures[i],
                .inside = {},
                .depth = render_depth(surface, views.cameras[i]),
                .focal_px = std::sqrt(std::abs(views.cameras[i].K(0, 0) * views.cameras[i].K(1, 1)))};
  cv::distanceTransform(views.mattes[i].alpha >= 128, view.inside, cv::DIST_L2, 3, CV_32F);
  return view;
}

// Whether everything about the pixel lies at the point's depth: nothing before it, no edge beside it.
bool is_open(const SeenView& view, cv::Point at, int half_window, double depth, double cosine) {
  const double slope = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine;
  const double tolerance = depth / view.focal_px * (kDepthTolerance + 1.5 * half_window * slope);
  for (int y = at.y - half_window; y <= at.y + half_window; ++y)
    for (int x = at.x - half_window; x <= at.x + half_window; ++x)
      if (!(std::abs(view.depth.depth.at<float>(y, x) - depth) <= tolerance)) return false;
  return true;
}

// The mean of the window in linear light, if it is one colour.
std::optional<Eigen::Vector3d> colour_at(const cv::Mat& rgb, cv::Point at, const ColourSampleOptions& options) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  for (int y = at.y - options.half_window; y <= at.y + options.half_window; ++y)
    for (int x = at.x - options.half_window; x <= at.x + options.half_window; ++x) {
      const auto& pixel = rgb.at<cv::Vec3b>(y, x);
      const auto [least, most] = std::minmax({pixel[0], pixel[1], pixel[2]});
      if (least < kDarkest || most > kBrightest) return std::nullopt;
      const Eigen::Vector3d light = capture::linear_of(pixel);
      sum += light;
      squares += light.cwiseProduct(light);
    }
  const double count = std::pow(2 * options.half_window + 1, 2);
  const Eigen::Vector3d mean = sum / count, variance = squares / count - mean.cwiseProduct(mean);
  if (std::sqrt(std::max(0.0, variance.sum())) > options.most_variation * mean.sum()) return std::nullopt;
  return mean;
}

std::optional<capture::ColourSample> sample(const SeenView& view, const Eigen::Vector3d& point,
                                            const Eigen::Vector3d& normal, std::size_t place,
                                            const ColourSampleOptions& options) {
  const double cosine = normal.dot((view.model->centre() - point).normalized());
  if (!(cosine >= options.least_cosine)) return std::nullopt;
  const auto pixel = capture::project(*view.model, point);
  if (!pixel) return std::nullopt;
  const cv::Point at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
  const int edge = options.half_window;
  if (at.x < edge || at.y < edge || at.x + edge >= view.rgb->cols || at.y + edge >= view.rgb->rows) return std::nullopt;
  if (view.inside.at<float>(at) < options.least_inside_px) return std::nullopt;
  const double depth = view.model->R.row(2).dot(point) + view.model->t.z();
  if (!is_open(view, at, edge, depth, cosine)) return std::nullopt;
  const auto colour = colour_at(*view.rgb, at, options);
  if (!colour) return std::nullopt;
  return capture::ColourSample{view.camera, place, *colour};
}

}  // namespace

std::vector<capture::ColourSample> colour_samples(const TriangleMesh& surface, const FrameViews& views,
                                                  std::span<const std::string> names, std::size_t first_place,
                                                  const ColourSampleOptions& options) {
  std::vector<SeenView> seen(views.cameras.size());
  std::vector<std::size_t> cameras;
  for (const auto& camera : views.cameras) {
    const auto at = std::find(names.begin(), names.end(), camera.name);
    if (at == names.end()) throw InvalidInput(camera.name + " is not among the cameras whose colours are compared");
    cameras.push_back(static_cast<std::size_t>(at - names.begin()));
  }
  tbb::parallel_for(std::size_t{0}, seen.size(),
                    [&](std::size_t i) { seen[i] = prepare(views, i, cameras[i], surface); });
  const std::size_t count = surface.positions.size(),
                    step = std::max<std::size_t>(1, count / std::max<std::size_t>(1, options.points));
  std::vector<capture::ColourSample> samples;
  for (std::size_t vertex = 0; vertex < count; vertex += step) {
    std::vector<capture::ColourSample> of_point;
    for (const auto& view : seen)
      if (auto one = sample(view, surface.positions[vertex].cast<double>(), surface.normals[vertex].cast<double>(),
                            first_place + vertex, options))
        of_point.push_back(*one);
    if (of_point.size() >= 2) samples.insert(samples.end(), of_point.begin(), of_point.end());
  }
  return samples;
}

}  // namespace rotunda::recon
