#pragma once
// What a lens gets wrong beside geometry (which is the CameraModel's): softness, and lateral colour, the slightly
// different size of the picture in red and blue. Both differ from camera to camera.
#include <opencv2/core.hpp>

#include "capture/camera_model.h"
#include "simulator/studio/figure_renderer.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct LensFlaws {
  double blur_px = 0.0;                      // standard deviation of the point spread, pixels
  double red_scale = 1.0, blue_scale = 1.0;  // size of the red and the blue picture against green's, which is true
  cv::Point2d centre;                        // about which they are larger: the principal point, pixels
  bool has_colour() const { return red_scale != 1.0 || blue_scale != 1.0; }
};
// Of the camera with this number; a fixed function of the options' seed.
LensFlaws lens_flaws(const capture::CameraModel& camera, std::size_t number, const SensorOptions& options);

// A sharp picture of linear light (CV_32FC3) as the lens gives it.
void look_through(const LensFlaws& lens, cv::Mat& linear);

// Figures before a picture that has already gone through the lens. `matte` (CV_8UC1) gets green's cover.
void lay_figures(const LensFlaws& lens, FigureLayer layer, cv::Mat& linear, cv::Mat& matte);

}  // namespace rotunda::simulator
