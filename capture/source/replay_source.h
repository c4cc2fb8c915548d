#pragma once
// A camera of a recorded take as a camera of the rig: source "replay", device the take's folder, by the camera's name.
// In freerun it sends frame set (time / period) mod length at every multiple of the period on the rig's clock, so that
// the cameras of one take stay together whenever each was started, over and over; period: that of the rig's rate, as
// recorded or any other. In software mode a trigger sends the next frame. Frames keep their distance from their trigger
// and their exposure; what is a hole in the take is none sent.
#include <memory>

#include "capture/source/source.h"

namespace rotunda::capture {

std::unique_ptr<Source> make_replay_source(const SourceSettings& settings);

// Takes do not answer: always none.
std::vector<DiscoveredCamera> discover_replay_cameras();

}  // namespace rotunda::capture
