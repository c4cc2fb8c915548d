#pragma once
// Calibrations as JSON, with OpenCV's conventions as camera_model.h has them.
// Written: { "unit": "m", "cameras": [ { "name", "image_size": [w, h], "K", "dist": [k1, k2, p1, p2, k3], "R", "t",
// "rms_px" } ] }. Read as well: `cameras` as an object by name, or the list or the object alone; width and height, or
// `resolution`; `distCoef`, `dist_coeffs` or `distortion`; R as nested rows, nine numbers or, as `rvec`, a Rodrigues
// vector; t (or `tvec`) as three numbers or a column.
#include <filesystem>
#include <string>

#include "capture/calibration/imported_calibration.h"

namespace rotunda::capture {

// Throws ConfigError with every mistake, each with its place in the document ("cameras[3].K (cam03)").
ImportedCalibration read_camera_json(const std::filesystem::path& file);
std::string camera_json(const CalibrationFile& calibration);  // 17 digits

}  // namespace rotunda::capture
