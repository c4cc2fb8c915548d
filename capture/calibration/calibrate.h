#pragma once
// Pictures of boards to a calibrated rig: boards found in every picture, each camera by itself, the cameras placed by
// the boards they see together, one adjustment of everything, then once more with the boards the detector missed; last,
// what is wrong and how far to trust it (calibration_result.h).
#include <functional>
#include <stop_token>

#include "capture/calibration/bundle_adjustment.h"
#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

// Pictures by camera and moment, wherever they come from.
struct BoardPictures {
  std::vector<std::string> cameras;
  std::vector<std::string> moments;  // in the order of time
  // Grey, CV_8UC1 or CV_16UC1, one size a camera; empty where there is none. Called from several threads.
  std::function<cv::Mat(std::size_t camera, std::size_t moment)> grey;
  std::function<std::filesystem::path(std::size_t camera, std::size_t moment)> file = {};  // for the report
};

struct CalibrateOptions {
  std::vector<Board> boards;
  std::vector<CameraModel> known;  // intrinsics by camera name: kept
  std::string world_from;          // a camera's name: its frame is the world; else the board on the floor
  bool bend = false;               // boards may sag
  bool second_pass = true;         // look for missed boards, fit all corners anew
  std::function<void(const std::string& step, std::size_t done, std::size_t total)> progress = {};
};

// Throws InvalidInput if nothing can be calibrated: no board anywhere, one camera only, too few moments; the message
// says what was found instead. Everything less is told in the result.
CalibrationResult calibrate(const BoardPictures& pictures, const CalibrateOptions& options,
                            const std::stop_token& stop = {});

// The same from corners that were found already; `sizes` are cameras with name, width and height.
CalibrationResult calibrate_sightings(std::span<const CameraModel> sizes, std::vector<std::string> moments,
                                      std::vector<Sighting> sightings, const CalibrateOptions& options);

}  // namespace rotunda::capture
