#pragma once
// From linear light to what a camera's converter gives, by EMVA 1288's linear model: vignetting, exposure time, shot
// noise, dark current and hot pixels, read noise, gain, 12-bit converter; then the camera's own white balance and
// gamma. Every channel of a pixel is a photosite with noise of its own, so picking one a pixel (pixel_encoding.h) gives
// what a mosaic sensor gives. All formats carry the sRGB curve, as cameras do whose Gamma feature is on: the key and
// the colours of a take want it.
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace rotunda::simulator {

// What a client can set on a camera.
struct CameraSettings {
  double exposure_s = 0.005;
  double gain_db = 0.0;
  double red_balance = 1.0, blue_balance = 1.0;  // factors on the camera's own white balance
  bool operator==(const CameraSettings&) const = default;
};

struct SensorOptions {
  double full_well = 12000.0;       // electrons at the converter's full scale, at 0 dB
  double read_noise = 9.0;          // electrons
  double vignetting = 0.12;         // light lost in the picture's corner, a fraction; cameras differ by a third of it
  double gain_spread = 0.04;        // how much cameras differ in exposure, a fraction either way
  double balance_spread = 0.02;     // and in red and blue
  double pixel_spread = 0.004;      // standard deviation of the pixels' sensitivity (PRNU)
  double hot_pixels_per_mega = 40;  // of a million pixels
  double lens_blur_px = 0.40;       // standard deviation of the lens's point spread, pixels
  double lens_blur_spread = 0.25;   // how much lenses differ in it, a fraction either way
  double lateral_colour_px = 0.25;  // red lies so much farther out in the picture's corner, blue 0.7 of it farther in;
                                    // lenses differ by half of it
  std::vector<CameraSettings> cameras;  // one each; those beyond the end have the defaults
  std::uint32_t seed = 1;
};

CameraSettings settings_of(const SensorOptions& options, std::size_t camera);

// How a camera turns electrons into codes.
struct SensorResponse {
  float read_noise = 0.0F;          // electrons
  float codes_per_electron = 0.0F;  // of the converter, by gain
  std::array<std::vector<std::uint16_t>, 3>
      curve;  // red, green, blue: code to balanced code on the sRGB curve, 12 bits
};

// Light of 1 fills the green pixels of a camera that exposes so long at 0 dB.
inline constexpr double kReferenceExposure = 0.005;  // seconds

// One camera's. Everything is a fixed function of seed, camera and frame.
class Sensor {
 public:
  Sensor(cv::Size size, std::size_t camera, const SensorOptions& options);

  // CV_32FC3 linear light, red, green, blue, to CV_16UC3, 0 to 4095, on the sRGB curve.
  cv::Mat expose(const cv::Mat& linear, std::uint64_t frame) const;

 private:
  struct HotPixel {
    int x, y;
    float electrons;
  };
  void draw_hot_pixels(const SensorOptions& options);

  std::size_t camera_;
  CameraSettings settings_;
  std::uint32_t seed_;
  SensorResponse response_;
  cv::Vec3f electrons_;        // of light 1 in the middle of the picture
  cv::Mat flat_;               // CV_32FC1: vignetting times pixel sensitivity
  std::vector<HotPixel> hot_;  // by row
};

// The upper eight bits, rounded: CV_8UC3 sRGB.
cv::Mat to_8bit(const cv::Mat& deep);

}  // namespace rotunda::simulator
