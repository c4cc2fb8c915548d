#pragma once
// The studio as its cameras see it: backdrop, shadow, figures, lens, sensor. Deterministic: a picture is a fixed
// function of performance, camera, time, frame number and sensor seed. Owns an OpenGL context: use it from the thread
// that made it, with no other context current there.
#include <memory>

#include "playback/display/headless.h"
#include "simulator/people/performance.h"
#include "simulator/studio/backdrop.h"
#include "simulator/studio/figure_renderer.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ScenePicture {
  cv::Mat rgb;    // CV_8UC3, sRGB, with noise, before the mosaic
  cv::Mat matte;  // CV_8UC1: truth, the share of each pixel the figures cover, 255 all
};

class SceneRenderer {
 public:
  // `performance` is lent.
  SceneRenderer(const Performance& performance, std::vector<capture::CameraModel> cameras, SensorOptions sensor = {});
  ~SceneRenderer();

  // The performance at a time (seconds) before camera `camera`; `frame` seeds the noise.
  ScenePicture picture(std::size_t camera, double seconds, std::uint64_t frame);
  // All cameras of one moment: the surfaces are worked out once.
  std::vector<ScenePicture> pictures(double seconds, std::uint64_t frame);
  cv::Mat clean_plate(std::size_t camera);  // the empty studio, with noise

  const Performance& performance() const { return performance_; }
  const std::vector<capture::CameraModel>& cameras() const { return cameras_; }

 private:
  ScenePicture compose(std::size_t camera, const std::vector<recon::TriangleMesh>& surfaces,
                       const ContactShadow& shadow, std::uint64_t frame);

  const Performance& performance_;
  std::vector<capture::CameraModel> cameras_;
  SensorOptions sensor_;
  playback::HeadlessDisplay display_;
  std::vector<Backdrop> backdrops_;
  std::vector<std::unique_ptr<FigureRenderer>> renderers_;  // by supersampling: one for each picture width
  std::vector<FigureRenderer*> renderer_of_;                // of each camera
};

}  // namespace rotunda::simulator
