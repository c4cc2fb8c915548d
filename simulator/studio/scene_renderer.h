#pragma once
// The studio as its cameras see it: backdrop, shadow, figures, lens, sensor. Deterministic: a picture is a fixed
// function of performance, camera, time, frame number and sensor options, on any number of threads.
#include "simulator/people/performance.h"
#include "simulator/studio/backdrop.h"
#include "simulator/studio/figure_renderer.h"
#include "simulator/studio/lens.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ScenePicture {
  cv::Mat deep;   // CV_16UC3, as the sensor gives it before the mosaic: for encode_pixels
  cv::Mat rgb;    // CV_8UC3, the same in eight bits
  cv::Mat matte;  // CV_8UC1: truth, the figures' share of each pixel's light while the shutter is open, 255 all
};

// `seconds` is the middle of the exposure, whatever its length: there the surfaces are those of the performance.
class SceneRenderer {
 public:
  // `performance` is lent.
  SceneRenderer(const Performance& performance, std::vector<capture::CameraModel> cameras, SensorOptions sensor = {},
                const BackdropOptions& backdrop = {});
  ~SceneRenderer();

  // The performance at a time before camera `camera`; `frame` seeds the noise.
  ScenePicture picture(std::size_t camera, double seconds, std::uint64_t frame) const;
  // All cameras of one moment: surfaces, light and shadows are worked out once.
  std::vector<ScenePicture> pictures(double seconds, std::uint64_t frame) const;
  cv::Mat clean_plate(std::size_t camera) const;  // the empty studio, with noise
  // Truth for taking out spill: CV_8UC3, the figures' own colours as the camera gives them but without noise and
  // without the backdrop that their edges are mixed with; black where they are not. `glow`: what walls and floor throw
  // on them.
  cv::Mat figures_alone(std::size_t camera, double seconds, const Eigen::Vector3f& glow) const;

  const Performance& performance() const { return performance_; }
  const std::vector<capture::CameraModel>& cameras() const { return cameras_; }
  const SensorOptions& sensor() const { return options_; }

 private:
  struct Moment;  // what all cameras see of one time
  Moment moment_at(double seconds) const;
  const LitFigures& figures_of(Moment& moment, std::size_t camera) const;
  FigureLayer figures_before(std::size_t camera, Moment& moment) const;
  ScenePicture develop(std::size_t camera, const FigureLayer& layer, const ContactShadow& shadow,
                       std::uint64_t frame) const;

  const Performance& performance_;
  std::vector<capture::CameraModel> cameras_;
  SensorOptions options_;
  FigureRenderer figures_;
  std::vector<Sensor> sensors_;
  std::vector<LensFlaws> lenses_;
  std::vector<Backdrop> backdrops_;
  Eigen::Vector3f glow_;  // of walls and floor
};

}  // namespace rotunda::simulator
