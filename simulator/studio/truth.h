#pragma once
// What the simulator knows about what it shows. Only tests, benchmarks and files for them may look at it.
// docs/simulator-truth.md describes the files.
#include <filesystem>

#include "capture/camera_model.h"
#include "capture/frame.h"
#include "simulator/people/performance.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ScenePicture;

// The performer's surface in an exposure that starts then: world, metres, normals, colours.
recon::TriangleMesh truth_mesh(const Performance& performance, capture::Timestamp exposure_start);

// Depth along the optical axis of the nearest surface at each pixel's centre, metres (CV_32FC1); 0 where there is none.
cv::Mat true_depth(const capture::CameraModel& camera, const std::vector<recon::TriangleMesh>& surfaces);

// What is true of an act, as files. All throw std::system_error if a file cannot be written.
class TruthFiles {
 public:
  // Writes what holds for all act frames. Frames of the same `key` that an earlier run has written are kept, those of
  // another are removed; without a key all are. `sensor`: what the cameras' lenses were told to get wrong.
  TruthFiles(std::filesystem::path directory, const Performance& performance,
             const std::vector<capture::CameraModel>& cameras, int frames, const std::string& key = {},
             const SensorOptions& sensor = {});

  bool has(int frame) const;
  void write_frame(int frame, const std::vector<ScenePicture>& pictures) const;  // of all cameras

 private:
  std::filesystem::path directory_;
  const Performance& performance_;
  std::vector<capture::CameraModel> cameras_;
};

// "frame000042".
std::string frame_name(int frame);

}  // namespace rotunda::simulator
