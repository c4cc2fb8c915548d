#pragma once
// How far a calibration is to be trusted, and what would make it better: residuals, held-out moments, coverage,
// covariance, verdicts and advice in words.
#include "capture/calibration/bundle_adjustment.h"
#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

// Residuals of all corners, outliers marked; root mean squares and 95th percentiles a camera and over all.
void tell_residuals(const RigState& state, std::span<const Sighting> with_outliers, std::span<const Board> boards,
                    double outlier_px, CalibrationResult& result);

// Adjusts without every sixth moment that two cameras or more saw, fits only the boards' poses there, and tells what is
// left. Nothing is told with fewer than eight such moments.
void tell_held_out(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                   const AdjustmentOptions& options, CalibrationResult& result);

void tell_coverage(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                   CalibrationResult& result);

// Deviations, baselines and ties from the covariance.
void tell_deviations(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                     const AdjustmentOptions& options, CalibrationResult& result);

// Verdicts and advice, from all of the above.
void judge(CalibrationResult& result);

// In words where a picture lacks corners: "upper right and lower left"; empty if everywhere is some.
std::string uncovered_places(const ImageCoverage& coverage);
std::size_t uncovered_count(const ImageCoverage& coverage);  // of the picture's ninths

}  // namespace rotunda::capture
