#pragma once
// The rig live without a take: the cameras are triggered, their pictures watched, nothing is written.
#include <thread>

#include "rig/daemon/frame_set_stream.h"

namespace rotunda::rig {

class LiveSession {
 public:
  // `sink` gets every frame set, as FrameSetStream::Sink. Throws what FrameSetStream throws.
  LiveSession(const config::RigConfig& rig, CameraFleet& fleet, FrameSetStream::Sink sink);
  ~LiveSession();  // no trigger comes any more

  const FrameSetStream& stream() const { return stream_; }

 private:
  FrameSetStream stream_;
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
