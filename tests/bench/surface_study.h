#pragma once
// What the surface's benchmark and the fit of its laws look at: moments of the simulated people with every flaw of
// studio, lens and sensor, keyed as a take's pictures are, beside what is true of them.
#include <filesystem>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::bench {

struct SurfaceStudy {
  std::string person, act;
  std::vector<int> frames;  // of the act
  std::string rig;          // name of the cameras
  std::vector<capture::CameraModel> cameras;
  bool own_calibration = false;  // calibrate the rig as well
  std::string name() const { return person + "-" + act + "-" + rig; }
};

// What laws are fitted on, and what they are judged on: other people, other acts, other rigs too.
std::vector<SurfaceStudy> fitted_studies();
std::vector<SurfaceStudy> held_out_studies();

struct SurfaceMoment {
  std::string name;
  std::vector<capture::CameraModel> cameras;
  std::vector<cv::Mat> pictures;       // RGB, as a take has them
  std::vector<capture::Matte> truth;   // the figures' share of each pixel
  std::vector<capture::Matte> mattes;  // of the full key, cleaned up across the views
  // The same by the rig's own calibration from a board walk (own_calibration.h), where the study asks for it.
  std::vector<capture::CameraModel> own_cameras;
  std::vector<capture::Matte> own_mattes;
  recon::TriangleMesh body;  // true surface, world, metres
};

// `keep`: a folder where pictures and mattes are left and taken from the next time; none if empty.
std::vector<SurfaceMoment> moments_of(const SurfaceStudy& study, const std::filesystem::path& keep);

}  // namespace rotunda::bench
