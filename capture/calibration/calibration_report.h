#pragma once
// The report of a calibration: one HTML file with its pictures inside, to be kept beside calibration.yaml and read by
// whoever decides whether to trust it. Verdict and what to do first, then the rig, figures, coverage, views.
#include <string>

#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

struct CalibrationReportOptions {
  std::string title = "Calibration";
  std::size_t views_per_camera = 4;  // shown: the worst one, the others spread over the moments
};

// Reads the views' pictures; one that cannot be read is left grey. Throws InvalidInput if the result's vectors do not
// fit each other.
std::string calibration_report(const CalibrationResult& result, const CalibrationReportOptions& options = {});

}  // namespace rotunda::capture
