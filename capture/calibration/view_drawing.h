#pragma once
// One picture with the corners found in it, and one camera's whole picture plane with what was seen where, as SVG.
// Residuals are drawn as arrows from where a corner was found to where the calibration puts it, magnified.
#include <cstddef>
#include <string>

#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

// The magnification at which the largest residual that is no outlier spans about a tenth of a picture's width: 1, 2, 5,
// 10, 20, 50, ... 5000. One for the whole report, so that its drawings can be compared.
double residual_magnification(const CalibrationResult& result);

// The view's picture (read from its file, scaled down; grey where there is none) with corners and arrows.
std::string draw_view(const CalibrationResult& result, const CalibratedView& view, double magnification, int width);

// All corners that a camera saw: cells of the coverage grid, darker with more corners, and every residual.
std::string draw_coverage(const CalibrationResult& result, std::size_t camera, double magnification, int width);

}  // namespace rotunda::capture
