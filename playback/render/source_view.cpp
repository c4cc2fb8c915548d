#include "playback/render/source_view.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "capture/matte/despill.h"
#include "capture/srgb.h"
#include "config/errors.h"
#include "recon/colour/rim.h"

namespace rotunda::playback {
namespace {

constexpr double kFeather = 3.0;  // pixels; as surface_colour has it
constexpr int kFill = 31;         // pixels, odd: outside of the matte, colours are the performer's about so far away

void check(const recon::ColourView& view) {
  const cv::Size size(view.camera.width, view.camera.height);
  if (view.rgb.size() != size || view.rgb.type() != CV_8UC3 || view.matte.alpha.size() != size ||
      view.matte.alpha.type() != CV_8UC1)
    throw InvalidInput(
        fmt::format("{}: picture ({} x {}) and matte ({} x {}) must be of the calibration's size, {} x "
                    "{}",
                    view.camera.name, view.rgb.cols, view.rgb.rows, view.matte.alpha.cols, view.matte.alpha.rows,
                    size.width, size.height));
}

// Outside of `inside` the mean of what is inside near by; black where nothing is.
void fill_outside(cv::Mat& rgb, const cv::Mat& inside) {
  cv::Mat kept(rgb.size(), CV_8UC3, cv::Scalar::all(0)), sums, share;
  rgb.copyTo(kept, inside);
  cv::boxFilter(kept, sums, CV_32F, {kFill, kFill}, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::boxFilter(inside, share, CV_32F, {kFill, kFill}, {-1, -1}, true, cv::BORDER_CONSTANT);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      if (inside.at<std::uint8_t>(y, x) != 0) continue;
      const float near = share.at<float>(y, x) / 255.0F;
      rgb.at<cv::Vec3b>(y, x) = near > 0.0F ? cv::Vec3b(sums.at<cv::Vec3f>(y, x) * (1.0F / near)) : cv::Vec3b();
    }
}

cv::Mat trust_of(const cv::Mat& depth) {
  cv::Mat trust(depth.size(), CV_8UC1);
  std::transform(depth.begin<float>(), depth.end<float>(), trust.begin<std::uint8_t>(), [](float inside) {
    if (inside <= 0.0F) return std::uint8_t{0};
    return std::max(std::uint8_t{1}, cv::saturate_cast<std::uint8_t>(255.0 * recon::outline_weight(inside, kFeather)));
  });
  return trust;
}

}  // namespace

SourceView source_view(const recon::ColourView& view, capture::Backdrop backdrop) {
  check(view);
  const cv::Mat clean = view.clean.empty() ? capture::despilled(view.rgb, view.matte, backdrop) : view.clean;
  const cv::Mat depth = recon::depth_inside(view.matte);
  cv::Mat rgb = recon::rim_from_inside(clean, depth);
  fill_outside(rgb, depth > 0.0F);
  if (view.colour != Eigen::Matrix3d::Identity()) rgb = capture::with_matrix(rgb, view.colour);
  SourceView source{view.camera, {}};
  const std::vector<cv::Mat> layers{rgb, trust_of(depth)};
  source.rgba.create(rgb.size(), CV_8UC4);
  const int order[] = {0, 0, 1, 1, 2, 2, 3, 3};
  std::vector<cv::Mat> filled{source.rgba};
  cv::mixChannels(layers, filled, order, 4);
  return source;
}

std::vector<SourceView> source_views(const recon::FrameViews& views) {
  const auto colour = recon::colour_views(views);
  std::vector<SourceView> sources(colour.size());
  tbb::parallel_for(std::size_t{0}, colour.size(),
                    [&](std::size_t i) { sources[i] = source_view(colour[i], views.backdrop); });
  return sources;
}

}  // namespace rotunda::playback
