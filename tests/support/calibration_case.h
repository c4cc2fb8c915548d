#pragma once
// What tests of whole calibrations begin with and compare.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "capture/calibration/calibrate.h"

namespace rotunda::tests {

inline const capture::Board kBoard{};

inline std::vector<std::string> names_of(std::size_t moments) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < moments; ++i) names.push_back("m" + std::to_string(i));
  return names;
}

inline capture::CalibrateOptions options() {
  capture::CalibrateOptions options;
  options.boards = {kBoard};
  return options;
}

inline const capture::CameraModel& named(const std::string& name, const std::vector<capture::CameraModel>& cameras) {
  return *std::find_if(cameras.begin(), cameras.end(), [&](const auto& camera) { return camera.name == name; });
}

// Metres.
inline double worst_baseline(const std::vector<capture::CameraModel>& found,
                             const std::vector<capture::CameraModel>& rig) {
  double worst = 0.0;
  for (const auto& a : found)
    for (const auto& b : found)
      worst = std::max(worst, std::abs((a.centre() - b.centre()).norm() -
                                       (named(a.name, rig).centre() - named(b.name, rig).centre()).norm()));
  return worst;
}

}  // namespace rotunda::tests
