#pragma once
// Every picture of an act, rendered ahead, found by the time an exposure starts. What a camera shows is a function of
// that time alone: the act runs on the rig's clock, on the 40 ms grid, for all cameras alike.
#include <functional>
#include <span>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

class SceneRenderer;
struct ScenePicture;

class FrameCache {
 public:
  // Told of each act frame once its pictures are there: for progress and truth.
  using OnFrame = std::function<void(int act_frame, const std::vector<ScenePicture>& pictures)>;

  // Renders all frames now, on the calling thread (which must own the renderer).
  FrameCache(SceneRenderer& studio, capture::PixelFormat format, const OnFrame& on_frame = {});

  // As the camera sends it; valid as long as the cache. May be called from any thread.
  std::span<const std::uint8_t> picture_at(std::size_t camera, capture::Timestamp exposure_start) const;
  std::span<const std::uint8_t> picture(std::size_t camera, int act_frame) const;

 private:
  std::vector<std::vector<std::vector<std::uint8_t>>> pictures_;  // [act frame][camera]
};

}  // namespace rotunda::simulator
