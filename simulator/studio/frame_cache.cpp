#include "simulator/studio/frame_cache.h"

#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {

int act_frame_at(capture::Timestamp exposure_start, Act act) {
  constexpr std::int64_t kStepNs = 40'000'000;
  const std::int64_t step = (exposure_start.time_since_epoch().count() + kStepNs / 2) / kStepNs;
  return static_cast<int>(step % act_frames(act));
}

double act_seconds(capture::Timestamp exposure_start, Act act) {
  return act_frame_at(exposure_start, act) * kActStep;
}

FrameCache::FrameCache(SceneRenderer& studio, Act act, capture::PixelFormat format, const OnFrame& on_frame)
    : act_(act) {
  const int frames = act_frames(act);
  for (int frame = 0; frame < frames; ++frame) {
    auto& of_frame = pictures_.emplace_back();
    const Pose pose = pose_at(studio.person().skeleton, act, frame * kActStep);
    const auto pictures = studio.pictures(pose, static_cast<std::uint64_t>(frame));
    for (const auto& picture : pictures) of_frame.push_back(encode_pixels(picture.rgb, format));
    if (on_frame) on_frame(frame, pictures);
  }
}

std::span<const std::uint8_t> FrameCache::picture_at(std::size_t camera, capture::Timestamp exposure_start) const {
  return picture(camera, act_frame_at(exposure_start, act_));
}

std::span<const std::uint8_t> FrameCache::picture(std::size_t camera, int act_frame) const {
  return pictures_.at(static_cast<std::size_t>(act_frame)).at(camera);
}

}  // namespace rotunda::simulator
