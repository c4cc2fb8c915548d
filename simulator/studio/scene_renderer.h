#pragma once
// The studio as its cameras see it: backdrop, shadow, person, lens, sensor. Deterministic: a picture is a fixed
// function of person, camera, pose, frame number and sensor seed. Owns an OpenGL context: use it from the thread that
// made it, with no other context current there.
#include <memory>

#include "playback/display/headless.h"
#include "simulator/people/act.h"
#include "simulator/studio/backdrop.h"
#include "simulator/studio/person_renderer.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ScenePicture {
  cv::Mat rgb;    // CV_8UC3, sRGB, with noise, before the mosaic
  cv::Mat matte;  // CV_8UC1: truth, the share of each pixel the person covers, 255 all
};

class SceneRenderer {
 public:
  SceneRenderer(Person person, std::vector<capture::CameraModel> cameras, SensorOptions sensor = {});
  ~SceneRenderer();

  // The person in `pose` before camera `camera`; `frame` seeds the noise.
  ScenePicture picture(std::size_t camera, const Pose& pose, std::uint64_t frame);
  // All cameras of one moment: the pose is worked out once.
  std::vector<ScenePicture> pictures(const Pose& pose, std::uint64_t frame);
  cv::Mat clean_plate(std::size_t camera);  // the empty studio, with noise

  const Person& person() const { return person_; }
  const std::vector<capture::CameraModel>& cameras() const { return cameras_; }

 private:
  ScenePicture compose(std::size_t camera, const recon::TriangleMesh& body, const ContactShadow& shadow,
                       std::uint64_t frame);

  Person person_;
  std::vector<capture::CameraModel> cameras_;
  SensorOptions sensor_;
  playback::HeadlessDisplay display_;
  std::vector<Backdrop> backdrops_;
  std::vector<std::unique_ptr<PersonRenderer>> renderers_;  // by supersampling: one for each picture width
  std::vector<PersonRenderer*> renderer_of_;                // of each camera
};

}  // namespace rotunda::simulator
