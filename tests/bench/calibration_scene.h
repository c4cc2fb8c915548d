#pragma once
// Pictures of a calibration board before the simulated studio's cameras, with all that their lenses and sensors get
// wrong, and the truth about them. Metres; world as the studio's, z up.
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "capture/calibration/board.h"
#include "capture/calibration/calibration_result.h"
#include "capture/camera_model.h"

namespace rotunda::bench {

struct Scene {
  std::string name;
  capture::Board board;
  std::vector<capture::CameraModel> truth;
  std::vector<Eigen::Isometry3d> poses;    // world from board, by moment
  std::vector<std::vector<cv::Mat>> grey;  // by camera, then moment
};

// Sixty moments of the board alone, held still at places all over the volume. Before a rig with strongly distorting
// lenses, or these cameras.
Scene show_alone(const std::string& name, const capture::Board& board);
Scene show_alone(const std::string& name, const capture::Board& board,
                 const std::vector<capture::CameraModel>& cameras);

// Sixty moments of the act "board": a person carries it through the volume and lays it on the floor. Before the same.
Scene show_carried();
Scene show_carried(const std::vector<capture::CameraModel>& cameras);

// What the program makes of its pictures.
capture::CalibrationResult calibrated(const Scene& scene);

}  // namespace rotunda::bench
