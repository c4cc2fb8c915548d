#include "simulator/studio/frame_cache.h"

#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {

FrameCache::FrameCache(SceneRenderer& studio, capture::PixelFormat format, const OnFrame& on_frame) {
  for (int frame = 0; frame < studio.performance().frames(); ++frame) {
    auto& of_frame = pictures_.emplace_back();
    const auto pictures = studio.pictures(act_seconds(frame), static_cast<std::uint64_t>(frame));
    for (const auto& picture : pictures) of_frame.push_back(encode_pixels(picture.deep, format));
    if (on_frame) on_frame(frame, pictures);
  }
}

std::span<const std::uint8_t> FrameCache::picture_at(std::size_t camera, capture::Timestamp exposure_start) const {
  return picture(camera, act_frame_at(exposure_start, static_cast<int>(pictures_.size())));
}

std::span<const std::uint8_t> FrameCache::picture(std::size_t camera, int act_frame) const {
  return pictures_.at(static_cast<std::size_t>(act_frame)).at(camera);
}

}  // namespace rotunda::simulator
