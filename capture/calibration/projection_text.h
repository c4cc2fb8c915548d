#pragma once
// Projection matrices as text, in the forms that data sets use; rows of numbers, '#' begins a comment:
//   cam00 p11 p12 ... p34                 a line a camera, row by row
//   cam00                                 or a name, alone, and three lines of four numbers; a line CONTOUR between
//   name k11 ... k33 r11 ... r33 t1 t2 t3 or K, R, t apart (21 numbers; a line with the count may come first)
// or a folder with a file of twelve numbers a camera (<camera>.txt, .P; a first line CONTOUR).
// Pixel (0, 0) is the centre of the top-left pixel. A comment "image_size cam00 720 576" says a picture's size.
#include <filesystem>

#include "capture/calibration/imported_calibration.h"

namespace rotunda::capture {

// Throws ConfigError naming file, line and column (and the camera, once its name is known).
ImportedCalibration read_projection_text(const std::filesystem::path& file_or_folder);
// The first form, 17 digits. Distortion, which a matrix cannot hold, is left out; the caller asks first.
// Throws InvalidInput for a name of several words.
std::string projection_text(const CalibrationFile& calibration);

}  // namespace rotunda::capture
