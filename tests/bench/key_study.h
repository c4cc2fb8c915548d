#pragma once
// What the key's benchmark looks at: moments of the simulated people with every flaw of studio, lens and sensor, as
// their cameras send them, beside what is true of them.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/frame.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::bench {

struct KeyStudy {
  std::string person, act;
  std::vector<int> frames;  // of the act
  simulator::SensorOptions sensor;
  simulator::BackdropOptions backdrop;
  std::vector<capture::CameraModel> cameras;
  std::string name() const;
};

// What constants are chosen on, and what they are judged on: other acts, another room, other cameras and lenses, two
// people more.
std::vector<KeyStudy> development_studies();
std::vector<KeyStudy> held_out_studies();

struct KeyView {
  capture::CameraModel camera;
  capture::Image image;  // BayerRG8
  cv::Mat truth;         // CV_8UC1
  cv::Mat own, unspilt;  // CV_8UC3: the performer's own colours, with the screen's glow on them and without
};
struct KeyMoment {
  std::vector<KeyView> views;
};

struct RenderedStudy {
  std::string person;
  std::vector<KeyMoment> moments;
  std::vector<cv::Mat> plates;  // CV_8UC3, demosaiced as the views are
};

// `keep`: a folder where rendered pictures are left and taken from the next time; none if empty.
RenderedStudy render(const KeyStudy& study, const std::filesystem::path& keep);

// By camera, `count` pictures (CV_8UC3) from all over the study's act while the lamps drift: 8 % too dark at first, 4 %
// too bright in the end, red gaining 3 % on blue. The study's own moments are lit as the middle.
std::vector<std::vector<cv::Mat>> render_drifting_take(const KeyStudy& study, int count,
                                                       const std::filesystem::path& keep);

}  // namespace rotunda::bench
