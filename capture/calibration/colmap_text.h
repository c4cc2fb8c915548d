#pragma once
// COLMAP's text model (Schoenberger, Frahm 2016): a folder with cameras.txt and images.txt. Image (x, y) = (0, 0) is
// the *corner* of the top-left pixel there: principal points lie half a pixel further right and down than here. A world
// point X is at R(q) X + t in the camera (x right, y down, z forward), q = (w, x, y, z).
// Camera models read: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV with k4 = k5 = k6 = 0.
// Each image is a camera here; its name is the picture's without the ending, or its folder's where each picture has a
// folder of its own.
#include <filesystem>
#include <string>

#include "capture/calibration/imported_calibration.h"

namespace rotunda::capture {

// Throws ConfigError naming file, line and column.
ImportedCalibration read_colmap(const std::filesystem::path& folder);

struct ColmapText {
  std::string cameras, images, points;
};
// PINHOLE, or OPENCV or FULL_OPENCV as far as there is distortion; pictures are called <camera>.png. 17 digits. Skew,
// which COLMAP has not, is left out; the caller asks first. Throws InvalidInput for a left-handed camera.
ColmapText colmap_text(const CalibrationFile& calibration);

}  // namespace rotunda::capture
