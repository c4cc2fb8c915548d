#include "capture/calibration/view_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/calibration/html_page.h"
#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr const char* kFound = "#00a86b";
constexpr const char* kOutlier = "#d62828";
constexpr int kSharper = 2;  // embedded pixels a drawn one, for looking closer

// Picture plane to drawing: pixel centres to the drawing's corner-counted places.
struct Canvas {
  double scale = 1.0;
  int width = 0, height = 0;
  Eigen::Vector2d at(const Eigen::Vector2d& pixel) const { return scale * (pixel + Eigen::Vector2d(0.5, 0.5)); }
};

Canvas canvas_of(const CameraModel& camera, int width) {
  const double scale = static_cast<double>(width) / std::max(1, camera.width);
  return {scale, width, static_cast<int>(std::lround(scale * camera.height))};
}

std::string begin(const Canvas& canvas) {
  return fmt::format("<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\">", canvas.width,
                     canvas.height);
}

std::string arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour) {
  const Eigen::Vector2d along = to - from;
  const double length = along.norm();
  std::string svg = fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}", from.x(), from.y(), to.x(), to.y());
  if (length > 3.0) {  // a head only where it can be seen
    const Eigen::Vector2d back = to - along * (2.5 / length),
                          side = Eigen::Vector2d(-along.y(), along.x()) * (1.5 / length);
    svg += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}", (back + side).x(), (back + side).y(), to.x(),
                       to.y(), (back - side).x(), (back - side).y());
  }
  return svg + fmt::format("\" stroke=\"{}\" fill=\"none\" stroke-width=\"1\"/>", colour);
}

std::string residual(const Canvas& canvas, const CornerResidual& corner, double magnification) {
  return arrow(canvas.at(corner.pixel), canvas.at(corner.pixel - magnification * corner.off),
               corner.outlier ? kOutlier : kFound);
}

// What can be shown of the file; a page must not fail because a picture has gone since.
cv::Mat picture_of_view(const CalibratedView& view, const Canvas& canvas) {
  if (view.picture.empty()) return {};
  try {
    cv::Mat small;
    cv::resize(read_rgb(view.picture), small, {kSharper * canvas.width, kSharper * canvas.height}, 0, 0,
               cv::INTER_AREA);
    return small;
  } catch (const CorruptData&) {
    return {};
  }
}

std::string cell(const Canvas& canvas, const ImageCoverage& coverage, int x, int y, int most) {
  const int count = coverage.corners[static_cast<std::size_t>(y * coverage.columns + x)];
  const double width = static_cast<double>(canvas.width) / coverage.columns,
               height = static_cast<double>(canvas.height) / coverage.rows;
  std::string svg = fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"#3b82c4\" fill-opacity=\"{:.2f}\" "
      "stroke=\"#d5dae0\"/>",
      x * width, y * height, width, height,
      count == 0 ? 0.0 : 0.12 + 0.5 * std::sqrt(static_cast<double>(count) / most));
  if (count == 0)
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" text-anchor=\"middle\" fill=\"#a82b1f\">0</text>",
                    (x + 0.5) * width, (y + 0.5) * height + 4);
  return svg;
}

}  // namespace

double residual_magnification(const CalibrationResult& result) {
  double largest = 0.0;  // as a share of the picture's width
  for (const auto& view : result.views)
    for (const auto& corner : view.corners)
      if (!corner.outlier) largest = std::max(largest, corner.off.norm() / result.cameras[view.camera].width);
  double magnification = 1.0;
  for (const double power : {1.0, 10.0, 100.0, 1000.0})
    for (const double step : {1.0, 2.0, 5.0})
      if (largest * power * step <= 0.1) magnification = power * step;
  return magnification;
}

std::string draw_view(const CalibrationResult& result, const CalibratedView& view, double magnification, int width) {
  const Canvas canvas = canvas_of(result.cameras[view.camera], width);
  std::string svg = begin(canvas);
  const cv::Mat picture = picture_of_view(view, canvas);
  if (picture.empty())
    svg += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#e3e6ea\"/>", canvas.width, canvas.height);
  else
    svg +=
        fmt::format("<image width=\"{}\" height=\"{}\" href=\"{}\"/>", canvas.width, canvas.height, data_uri(picture));
  for (const auto& corner : view.corners) {
    const Eigen::Vector2d at = canvas.at(corner.pixel);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.2\" fill=\"none\" stroke=\"{}\"/>", at.x(), at.y(),
                       corner.outlier ? kOutlier : kFound);
    svg += residual(canvas, corner, magnification);
  }
  return svg + "</svg>";
}

std::string draw_coverage(const CalibrationResult& result, std::size_t camera, double magnification, int width) {
  const Canvas canvas = canvas_of(result.cameras[camera], width);
  const auto& coverage = result.quality[camera].coverage;
  std::string svg =
      begin(canvas) + fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>", canvas.width, canvas.height);
  const bool whole = coverage.corners.size() == static_cast<std::size_t>(coverage.columns * coverage.rows);
  const int most = whole ? std::max(1, *std::max_element(coverage.corners.begin(), coverage.corners.end())) : 1;
  for (int y = 0; whole && y < coverage.rows; ++y)
    for (int x = 0; x < coverage.columns; ++x) svg += cell(canvas, coverage, x, y, most);
  for (const auto& view : result.views)
    if (view.camera == camera)
      for (const auto& corner : view.corners) svg += residual(canvas, corner, magnification);
  return svg + "</svg>";
}

}  // namespace rotunda::capture
