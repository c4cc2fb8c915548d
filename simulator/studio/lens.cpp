#include "simulator/studio/lens.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

const cv::Size kKernel{5, 5};  // pixels: of blurs below 0.8

double deviation(std::size_t camera, std::int64_t property, std::uint32_t seed) {
  return 2.0 * hashed_unit(static_cast<std::int64_t>(camera), property, 0, seed + 61) - 1.0;
}

// Where the light of a pixel in a picture of another size is found in green's.
cv::Point2f in_green(const LensFlaws& lens, double scale, int x, int y) {
  return {static_cast<float>(lens.centre.x + (x - lens.centre.x) / scale),
          static_cast<float>(lens.centre.y + (y - lens.centre.y) / scale)};
}

// Colour channel and alpha of a layer between pixels; nothing outside.
cv::Vec2f sample(const cv::Mat& rgba, const cv::Point2f& at, int channel) {
  const float x = std::floor(at.x), y = std::floor(at.y), u = at.x - x, v = at.y - y;
  cv::Vec2f sum(0.0F, 0.0F);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int column = static_cast<int>(x) + i, row = static_cast<int>(y) + j;
      if (column < 0 || row < 0 || column >= rgba.cols || row >= rgba.rows) continue;
      const auto& pixel = rgba.at<cv::Vec4f>(row, column);
      const float share = (i ? u : 1.0F - u) * (j ? v : 1.0F - v);
      sum += share * cv::Vec2f(pixel[channel], pixel[3]);
    }
  return sum;
}

void shift_colour(const LensFlaws& lens, double scale, int channel, cv::Mat& linear) {
  cv::Mat plane, shifted, x(linear.size(), CV_32FC1), y(linear.size(), CV_32FC1);
  for (int row = 0; row < linear.rows; ++row)
    for (int column = 0; column < linear.cols; ++column) {
      const auto at = in_green(lens, scale, column, row);
      x.at<float>(row, column) = at.x;
      y.at<float>(row, column) = at.y;
    }
  cv::extractChannel(linear, plane, channel);
  cv::remap(plane, shifted, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::insertChannel(shifted, linear, channel);
}

}  // namespace

LensFlaws lens_flaws(const capture::CameraModel& camera, std::size_t number, const SensorOptions& options) {
  LensFlaws lens;
  lens.blur_px =
      std::max(0.0, options.lens_blur_px * (1.0 + options.lens_blur_spread * deviation(number, 1, options.seed)));
  lens.centre = {camera.K(0, 2), camera.K(1, 2)};
  const double corner = 0.5 * std::hypot(camera.width, camera.height);
  const auto scale = [&](double pixels, std::int64_t property) {
    return 1.0 + pixels * (1.0 + 0.5 * deviation(number, property, options.seed)) / corner;
  };
  lens.red_scale = scale(options.lateral_colour_px, 2);
  lens.blue_scale = scale(-0.7 * options.lateral_colour_px, 3);
  return lens;
}

void look_through(const LensFlaws& lens, cv::Mat& linear) {
  if (lens.blur_px > 0.0) cv::GaussianBlur(linear, linear, kKernel, lens.blur_px);
  if (!lens.has_colour()) return;
  shift_colour(lens, lens.red_scale, 0, linear);
  shift_colour(lens, lens.blue_scale, 2, linear);
}

void lay_figures(const LensFlaws& lens, FigureLayer layer, cv::Mat& linear, cv::Mat& matte) {
  if (layer.box.empty()) return;
  if (lens.blur_px > 0.0) cv::GaussianBlur(layer.rgba, layer.rgba, kKernel, lens.blur_px, 0, cv::BORDER_REPLICATE);
  const cv::Point2f corner(static_cast<float>(layer.box.x), static_cast<float>(layer.box.y));
  const bool has_colour = lens.has_colour();
  const auto lay_row = [&](int row) {
    const int y = layer.box.y + row;
    auto* pixel = linear.ptr<cv::Vec3f>(y) + layer.box.x;
    auto* cover = matte.ptr<std::uint8_t>(y) + layer.box.x;
    const auto* figure = layer.rgba.ptr<cv::Vec4f>(row);
    for (int x = 0; x < layer.box.width; ++x) {
      const auto lay = [&](int channel, float light, float alpha) {
        pixel[x][channel] = light + pixel[x][channel] * (1.0F - alpha);
      };
      lay(1, figure[x][1], figure[x][3]);
      for (const int channel : {0, 2}) {
        if (!has_colour) {
          lay(channel, figure[x][channel], figure[x][3]);
          continue;
        }
        const auto at = in_green(lens, channel == 0 ? lens.red_scale : lens.blue_scale, layer.box.x + x, y) - corner;
        const auto shifted = sample(layer.rgba, at, channel);
        lay(channel, shifted[0], shifted[1]);
      }
      cover[x] = static_cast<std::uint8_t>(std::min(figure[x][3], 1.0F) * 255.0F + 0.5F);
    }
  };
  tbb::parallel_for(tbb::blocked_range<int>(0, layer.box.height, 16), [&](const auto& rows) {
    for (int row = rows.begin(); row < rows.end(); ++row) lay_row(row);
  });
}

}  // namespace rotunda::simulator
