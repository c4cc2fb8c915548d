#pragma once
// rotunda mocap --live: the skeleton that the daemon follows, shown and recorded.
#include <filesystem>
#include <functional>
#include <stop_token>

#include "recon/body/captured_motion.h"

namespace rotunda::rig {

struct LiveMocapRequest {
  std::filesystem::path socket;  // the daemon's
  double seconds = 0.0;          // of motion from the first frame with somebody on; 0: until `stop`
  bool json = false;             // print a line of JSON a frame
};

// What was followed, at the rig's rate: where a frame was not looked at, what lies between its neighbours. Empty if
// nobody was found. Tells once a second how it goes. Throws DeviceError if the daemon does not answer, its cameras do
// not run, or nothing comes.
recon::CapturedMotion capture_live(const LiveMocapRequest& request, std::stop_token stop);

}  // namespace rotunda::rig
