#pragma once
// calibration.yaml: the cameras of a rig as OpenCV FileStorage YAML, so that OpenCV in any language reads it.
//   unit: "m"            what t is measured in; absent or another for data from elsewhere (kept as it stands)
//   cameras: a sequence of maps
//     name, image_size [w, h], K 3x3, distortion 1x5 (k1 k2 p1 p2 k3), R 3x3 and t 3x1 with
//     x_cam = R x_world + t, rms_px
//     colour 3x3: linear light of the rig from that of this camera (calibration/colour_match.h); absent: the same
// Matrices may be !!opencv-matrix or plain (nested) sequences; distortion and rms_px may be absent (zero).
//
// Handedness. K may have skew, and det(R) may be -1: the set's world is then a mirror image, and is kept as the file
// gives it. Projection, hulls, outward normals and colour work in its coordinates without a special case (nothing but
// R and t ties them to the pictures); only who draws with such a camera must not cull by winding. A negative focal
// length means the same mirror: reading moves its sign into R and t (and p1, p2), so focal lengths are positive after.
//
// Errors: ConfigError with every mistake found, each with line, column and key ("cameras[3].K (cam03)").
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::capture {

struct CalibrationFile {
  std::string unit;  // "m" in files of this project; empty if the file does not say
  std::vector<CameraModel> cameras;
  std::map<std::string, Eigen::Matrix3d> colour;  // by camera, of those that have one

  // The identity where a camera has none.
  Eigen::Matrix3d colour_of(const std::string& camera) const;
};

CalibrationFile read_calibration_file(const std::filesystem::path& file);
std::vector<CameraModel> read_calibration(const std::filesystem::path& file);  // the cameras alone
// For K and distortion: R and t may be absent, and are those of a camera at the world's origin then.
std::vector<CameraModel> read_lenses(const std::filesystem::path& file);

// Replaces the file in one step; every number survives the round trip. Throws std::system_error if it cannot be
// written and InvalidInput if the cameras could not be read back (none, a name twice, an R that is no rotation...).
void write_calibration(const std::filesystem::path& file, const CalibrationFile& calibration);
void write_calibration(const std::filesystem::path& file, std::span<const CameraModel> cameras);  // unit "m"

}  // namespace rotunda::capture
