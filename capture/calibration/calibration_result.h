#pragma once
// What a calibration found and how far to trust it: plain values, from which the report is drawn and calibration.yaml
// written. Metres, pixels (0, 0 the middle of the upper left pixel), degrees where the name says so. Numbers of
// cameras, moments and boards are places in the vectors of CalibrationResult.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/calibration/board.h"
#include "capture/camera_model.h"

namespace rotunda::capture {

// good: as the rig allows; usable: will do, could be better; rejected: not to be worked with.
enum class Verdict { good, usable, rejected };
std::string to_string(Verdict verdict);
std::string in_times(std::size_t count);  // "once", "twice", "4 times"

struct CornerResidual {
  int corner = 0;                                   // of the board
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // where it was found
  Eigen::Vector2d off = Eigen::Vector2d::Zero();    // found minus where the calibration puts it, pixels
  bool outlier = false;                             // took no part
};

// One board in one picture.
struct CalibratedView {
  std::size_t camera = 0, moment = 0, board = 0;
  std::filesystem::path picture;  // the file, where there is one
  bool predicted = false;         // missed by the detector, found where the first calibration put it
  double rms_px = 0.0;            // per corner (both axes), outliers left out
  std::vector<CornerResidual> corners;
};

// Where in the picture corners were seen, as a grid over it.
struct ImageCoverage {
  int columns = 8, rows = 6;
  std::vector<int> corners;  // a cell, row by row
  double outermost_radius =
      0;  // of a corner about the principal point, as a share of the picture's own farthest corner
  double nearest = 0, farthest = 0;  // boards, metres from the camera
};

// Standard deviations of what the adjustment found, from its covariance; the pose's against the rig as a whole (after
// rigid alignment of all camera centres).
struct CameraDeviation {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  Eigen::Matrix<double, 5, 1> distortion = Eigen::Matrix<double, 5, 1>::Zero();
  double centre = 0;        // metres, root of the summed variances of x, y, z
  double rotation_deg = 0;  // likewise
  double rim_px = 0;        // of what it shows at its picture's rim, lens and pose together; 0: not known
};

struct CameraQuality {
  int views = 0, corners = 0, outliers = 0;
  double rms_px = 0.0, p95_px = 0.0;  // of the distances found to calibrated
  double held_out_rms_px = 0.0;       // at moments, or corners, that took no part
  ImageCoverage coverage;
  CameraDeviation deviation;
  Verdict verdict = Verdict::good;
  std::vector<std::string> advice;  // "cam07 saw the board 4 times, all in the lower left: show it upper right"
};

// Two cameras that saw boards at the same moments.
struct CameraTie {
  std::size_t a = 0, b = 0;
  int moments = 0;
  double baseline = 0.0;            // metres
  double baseline_deviation = 0.0;  // metres
};

struct BoardPose {
  std::size_t moment = 0, board = 0;
  Eigen::Isometry3d world_from_board = Eigen::Isometry3d::Identity();
};

// Where boards were, as a grid over the box that holds their corners.
struct VolumeCoverage {
  Eigen::AlignedBox3d box;        // world, metres
  Eigen::Array3i cells{6, 6, 4};  // x, y, z
  std::vector<int> views;         // a cell, x fastest: pictures of corners in it
  double share = 0.0;             // of the cells seen by two cameras or more
};

struct CalibrationResult {
  std::vector<CameraModel> cameras;  // of those that could be calibrated; rms_px filled
  std::vector<CameraQuality> quality;
  std::vector<std::string> moments;  // names, as the pictures' files have
  std::vector<Board> boards;
  std::vector<BoardPose> poses;
  std::vector<CalibratedView> views;
  std::vector<CameraTie> ties;
  VolumeCoverage volume;

  std::string world;             // what the world frame was taken from, in words
  bool kept_intrinsics = false;  // K and distortion were given
  double corner_noise_px = 0;    // standard deviation per axis, from the residuals' median
  double rms_px = 0, p95_px = 0;
  double held_out_rms_px = 0;  // over all cameras
  int held_out_moments = 0;    // 0: a fifth of every board's corners was held out instead
  int corners = 0, outliers = 0;
  double bend = 0;  // of the board, metres of sag over its diagonal; 0 where it was taken as flat

  Verdict verdict = Verdict::good;
  std::vector<std::string> problems;  // found and named: swapped cameras, a camera that moved, a wrong board
  std::vector<std::string> advice;    // what to do about it
};

// "at 9 moments", "at a fifth of the corners".
std::string held_out_where(const CalibrationResult& result);

}  // namespace rotunda::capture
