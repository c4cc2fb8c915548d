// Which nodes of this machine capture, as `rotunda cameras` lists them.
#include "capture/source/v4l2_camera.h"
#include "capture/source/v4l2_query.h"

namespace rotunda::capture {
std::vector<DiscoveredCamera> discover_v4l2_cameras(V4l2System& system) {
  std::vector<DiscoveredCamera> cameras;
  for (const auto& path : system.nodes()) {
    const V4l2Node node(system, path);
    v4l2_capability told{};
    if (!node || !node.ask(VIDIOC_QUERYCAP, told) || !captures(told)) continue;
    DiscoveredCamera camera{.kind = "v4l2",
                            .address = path,
                            .serial = system.serial_of(path),
                            .user_name = "",
                            .vendor = text(told.driver),
                            .model = text(told.card),
                            .mac = "",
                            .pixel_format = ""};
    for (const auto& format : formats_of(node, capture_type(told)))
      if (const auto ours = pixel_format_of(format.pixelformat); ours && camera.pixel_format.empty())
        camera.pixel_format = to_string(*ours);
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

}  // namespace rotunda::capture
