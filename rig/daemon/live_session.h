#pragma once
// The rig live without a take: the cameras are triggered, their pictures watched, nothing is written.
#include <thread>

#include "rig/daemon/frame_set_stream.h"

namespace rotunda::rig {

class LiveSession {
 public:
  // `onlooker` is shown every set. Throws what FrameSetStream throws.
  LiveSession(const config::RigConfig& rig, CameraFleet& fleet, Onlooker onlooker);
  ~LiveSession();  // no trigger comes any more

  const FrameSetStream& stream() const { return stream_; }

 private:
  FrameSetStream stream_;
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
