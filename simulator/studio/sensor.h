#pragma once
// From linear light to the camera's 8-bit picture: exposure and white balance of the individual camera, vignetting,
// shot and read noise (EMVA 1288's linear model), sRGB gamma. The mosaic comes after: pixel_encoding.h.
#include <cstdint>
#include <opencv2/core.hpp>

namespace rotunda::simulator {

struct SensorOptions {
  double full_well = 12000.0;    // electrons at white
  double read_noise = 9.0;       // electrons
  double vignetting = 0.12;      // light lost in the picture's corner, a fraction
  double gain_spread = 0.04;     // how much cameras differ in exposure, a fraction either way
  double balance_spread = 0.02;  // and in red and blue
  std::uint32_t seed = 1;
};

// CV_32FC3 linear to CV_8UC3 sRGB. The noise is a fixed function of seed, camera and frame.
cv::Mat expose(const cv::Mat& linear, std::size_t camera, std::uint64_t frame, const SensorOptions& options = {});

}  // namespace rotunda::simulator
