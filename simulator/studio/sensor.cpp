#include "simulator/studio/sensor.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simulator/people/solid_noise.h"
#include "simulator/studio/sensor_response.h"

namespace rotunda::simulator {
namespace {

// cos^4 of the angle to the axis, scaled so that the corner loses `loss`; times each pixel's own sensitivity.
cv::Mat flat_field(cv::Size size, double loss, double pixel_spread, std::uint32_t seed) {
  const double middle_x = 0.5 * (size.width - 1), middle_y = 0.5 * (size.height - 1);
  const double corner = 1.0 / std::sqrt(1.0 - loss) - 1.0;  // tan^2 there
  const double scale = corner / (middle_x * middle_x + middle_y * middle_y);
  const auto& normal = normals();
  cv::Mat flat(size, CV_32FC1);
  tbb::parallel_for(0, size.height, [&](int y) {
    RowNoise random(hashed_unit(y, 1, 0, seed));
    for (int x = 0; x < size.width; ++x) {
      const double r2 = (x - middle_x) * (x - middle_x) + (y - middle_y) * (y - middle_y);
      const double spread = 1.0 + pixel_spread * static_cast<double>(normal[random.next_index()]);
      flat.at<float>(y, x) = static_cast<float>(spread / ((1.0 + scale * r2) * (1.0 + scale * r2)));
    }
  });
  return flat;
}

}  // namespace

CameraSettings settings_of(const SensorOptions& options, std::size_t camera) {
  return camera < options.cameras.size() ? options.cameras[camera] : CameraSettings{};
}

Sensor::Sensor(cv::Size size, std::size_t camera, const SensorOptions& options)
    : camera_(camera),
      settings_(settings_of(options, camera)),
      seed_(options.seed),
      response_(
          sensor_response(options, camera, settings_.gain_db, {settings_.red_balance, 1.0, settings_.blue_balance})) {
  const double exposed = options.full_well * settings_.exposure_s / kReferenceExposure *
                         (1.0 + options.gain_spread * deviation(camera, 1, seed_));
  for (int c = 0; c < 3; ++c)
    electrons_[c] = static_cast<float>(exposed * kFilterResponse[static_cast<std::size_t>(c)]);
  const auto camera_seed = static_cast<std::uint32_t>(seed_ + 7919 * (camera + 1));
  const double loss = options.vignetting * (1.0 + deviation(camera, 4, seed_) / 3.0);
  flat_ = flat_field(size, std::clamp(loss, 0.0, 0.9), options.pixel_spread, camera_seed);
  draw_hot_pixels(options);
}

// Dark currents of hot pixels spread over decades; twenty thousand electrons a second show at 5 ms.
void Sensor::draw_hot_pixels(const SensorOptions& options) {
  std::mt19937 random(static_cast<std::uint32_t>(seed_ + 104729 * (camera_ + 1)));
  const auto count = static_cast<int>(options.hot_pixels_per_mega * 1e-6 * flat_.size().area() + 0.5);
  for (int i = 0; i < count; ++i) {
    const int x = static_cast<int>(random() % static_cast<unsigned>(flat_.cols));
    const int y = static_cast<int>(random() % static_cast<unsigned>(flat_.rows));
    const double current = std::pow(10.0, 3.7 + 1.8 * static_cast<double>(random()) * 0x1p-32);  // 5,000 to 300,000 e/s
    hot_.push_back({x, y, static_cast<float>(current * settings_.exposure_s)});
  }
  std::sort(hot_.begin(), hot_.end(), [](const HotPixel& a, const HotPixel& b) { return a.y < b.y; });
}

cv::Mat Sensor::expose(const cv::Mat& linear, std::uint64_t frame) const {
  const auto& normal = normals();
  cv::Mat picture(linear.size(), CV_16UC3);
  const float read2 = response_.read_noise * response_.read_noise;
  tbb::parallel_for(tbb::blocked_range<int>(0, linear.rows, 16), [&](const tbb::blocked_range<int>& rows) {
    std::vector<cv::Vec3f> electrons(static_cast<std::size_t>(linear.cols));
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const auto* in = linear.ptr<cv::Vec3f>(y);
      const auto* flat = flat_.ptr<float>(y);
      for (int x = 0; x < linear.cols; ++x)
        for (int c = 0; c < 3; ++c) electrons[static_cast<std::size_t>(x)][c] = in[x][c] * flat[x] * electrons_[c];
      for (auto hot =
               std::lower_bound(hot_.begin(), hot_.end(), y, [](const HotPixel&h, int row) { return h.y < row; });
           hot != hot_.end() && hot->y == y; ++hot)
        electrons[static_cast<std::size_t>(hot->x)] += cv::Vec3f::all(hot->electrons);
      RowNoise random(camera_, frame, y, seed_);
      auto* out = picture.ptr<cv::Vec3w>(y);
      for (int x = 0; x < linear.cols; ++x)
        for (int c = 0; c < 3; ++c) {
          const float mean = electrons[static_cast<std::size_t>(x)][c];
          const float code =
              response_.codes_per_electron * (mean + std::sqrt(mean + read2) * normal[random.next_index()]);
          out[x][c] =
              response_.curve[static_cast<std::size_t>(c)]
                             [static_cast<std::size_t>(std::clamp(code + 0.5F, 0.0F, static_cast<float>(kFullScale)))];
        }
    }
  });
  return picture;
}

cv::Mat to_8bit(const cv::Mat& deep) {
  cv::Mat picture;
  deep.convertTo(picture, CV_8U, 255.0 / kFullScale);
  return picture;
}

}  // namespace rotunda::simulator
