#pragma once
// A calibration that was read from another program's file.
#include <string>
#include <vector>

#include "capture/calibration_file.h"

namespace rotunda::capture {

struct ImportedCalibration {
  CalibrationFile calibration;     // image sizes are 0 x 0 where the file does not say them
  std::vector<std::string> notes;  // what a person should know of it, a sentence each
};

}  // namespace rotunda::capture
