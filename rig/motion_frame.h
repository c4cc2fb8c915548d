#pragma once
// What the daemon sends who captures motion live, a frame at a time.
#include <cstdint>

#include "capture/frame.h"
#include "recon/live_motion.h"

namespace rotunda::rig {

struct MotionFrame {
  std::uint64_t trigger = 0;
  capture::Timestamp exposure;  // the moment it shows
  capture::Timestamp made;      // when it was ready
  recon::LiveMotionFrame motion;
};

}  // namespace rotunda::rig
