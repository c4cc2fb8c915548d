#pragma once
// Finding, opening and closing a GenICam camera. What a camera says of itself is checked before Aravis follows it.
#include <functional>
#include <memory>
#include <vector>

#include "capture/source/aravis_handle.h"
#include "capture/source/source.h"

namespace rotunda::capture {

// Calls `each` with the place of every camera that answers now, for arv_get_device_...(); takes a second.
void with_device_list(const std::function<void(unsigned)>& each);

std::vector<DiscoveredCamera> discover_aravis_cameras();

// Throws DeviceError if nobody answers, if its description is not sound, or if another program controls the camera.
GRef<ArvCamera> open_camera(const SourceSettings& settings);

// Aravis says goodbye to a camera, and waits seconds for the answer of one that has gone: then a thread of its own
// does, which keeps the stream callback's user data for as long as it takes.
void close_camera(GRef<ArvCamera> camera, GRef<ArvStream> stream, std::shared_ptr<void> user_data,
                  bool is_gone) noexcept;

}  // namespace rotunda::capture
