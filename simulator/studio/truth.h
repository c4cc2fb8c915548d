#pragma once
// What the simulator knows about what it shows. Only tests, benchmarks and files for them may look at it.
// A recorded frame's truth follows from its exposure_start (act_frame_at).
#include <filesystem>

#include "capture/frame.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

class SceneRenderer;
struct ScenePicture;

// The performer's surface in an exposure that starts then: world, metres, normals, colours.
recon::TriangleMesh truth_mesh(const Performance& performance, capture::Timestamp exposure_start);

// Writes what is true of an act as files for tests and benchmarks:
//   DIR/meshes/frame000000.ply, DIR/mattes/<camera>/frame000000.png (8-bit cover): number = act frame
//   DIR/calibration.yaml, DIR/truth.json: person, act, act frames and their step in nanoseconds, heel strikes, joint
//   centres. A recorded frame's act frame is round(exposure_start / step) modulo act frames.
// All throw std::system_error if a file cannot be written.
class TruthFiles {
 public:
  TruthFiles(std::filesystem::path directory, const SceneRenderer& studio, int frames);
  void write_frame(int frame, const std::vector<ScenePicture>& pictures) const;  // of all cameras

 private:
  std::filesystem::path directory_;
  const SceneRenderer& studio_;
};

// "frame000042".
std::string frame_name(int frame);

}  // namespace rotunda::simulator
