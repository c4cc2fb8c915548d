#pragma once
// The editor of markers: in a window (marker_desk.h tells its keys), or as a picture of what it shows.
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "recon/body/body_motion.h"
#include "recon/deform/marker_keeper.h"

namespace rotunda::playback {

struct EditMarkersOptions {
  int width = 1440, height = 810;  // pixels
  bool fullscreen = false;
  long picture_limit = 0;  // pictures drawn before it ends by itself; 0: none
  std::stop_token stop;
};

struct EditMarkersReport {
  long pictures = 0;
  double seconds = 0.0;
  std::optional<int> frame;  // of the motion, at the end; nothing: as scanned
};

// Returns when the window is closed, the operator quits, or it is asked to stop; what was not saved is kept (`keeper`).
// `editor`: of `scan`. Call it on the program's first thread. Throws DeviceError without a display.
EditMarkersReport edit_markers(const recon::PreparedScan& scan, recon::MarkerEditor& editor,
                               recon::MarkerKeeper& keeper, const recon::BodyMotion& motion,
                               const EditMarkersOptions& options = {});

// What the window shows: above as scanned, below the middle of the motion with residuals. CV_8UC3, RGB. Draws
// headless: no other GL context may be current on this thread.
cv::Mat picture_of_markers(const recon::PreparedScan& scan, recon::MarkerEditor& editor,
                           const recon::BodyMotion& motion, int width = 1280, int height = 720);

}  // namespace rotunda::playback
