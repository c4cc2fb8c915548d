#pragma once
// Cameras behind the kernel's Video for Linux API: USB (UVC) cameras, frame grabbers, sensors on a board. Pixels are
// copied out of the driver's memory, so that readers may hold them as long as they like and a camera that is pulled out
// takes nothing with it.
// A frame's exposure start is the driver's time stamp (less the exposure where the driver stamps a frame's end: the
// time its sensor takes to read out is not known) moved from CLOCK_MONOTONIC to the rig's clock; the moment of arrival
// where the driver has no such stamp. Trigger modes freerun and line.
#include "capture/source/source.h"
#include "capture/source/v4l2_system.h"

namespace rotunda::capture {

std::unique_ptr<Source> make_v4l2_source(const SourceSettings& settings);
std::unique_ptr<Source> make_v4l2_source(const SourceSettings& settings, V4l2System& system);
std::vector<DiscoveredCamera> discover_v4l2_cameras();

}  // namespace rotunda::capture
