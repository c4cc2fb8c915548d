#include "simulator/studio/render_ahead.h"

#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/truth.h"

namespace rotunda::simulator {
namespace {

// Renders `frames` and hands each frame's pictures to `keep`; false if stopped.
template <class Keep>
bool render(SceneRenderer& studio, const std::vector<int>& frames, const AheadOptions& options, const Keep& keep) {
  int done = 0;
  if (options.progress) options.progress(0, static_cast<int>(frames.size()));
  for (const int frame : frames) {
    if (options.stop.stop_requested()) return false;
    const auto pictures = studio.pictures(act_seconds(frame), static_cast<std::uint64_t>(frame));
    keep(frame, pictures);
    if (options.truth && !options.truth->has(frame)) options.truth->write_frame(frame, pictures);
    if (options.progress) options.progress(++done, static_cast<int>(frames.size()));
  }
  return true;
}

}  // namespace

PictureSet encode(const std::vector<ScenePicture>& pictures, capture::PixelFormat format) {
  PictureSet set;
  for (const auto& picture : pictures) set.push_back(encode_pixels(picture.deep, format));
  return set;
}

EntryShape shape_of(const std::vector<capture::CameraModel>& cameras, int frames, capture::PixelFormat format) {
  EntryShape shape{.frames = frames, .picture_bytes = {}};
  for (const auto& camera : cameras)
    shape.picture_bytes.push_back(encode_pixels(cv::Mat::zeros(camera.height, camera.width, CV_8UC3), format).size());
  return shape;
}

bool render_ahead(SceneRenderer& studio, CacheEntry& entry, const AheadOptions& options) {
  std::vector<int> frames;
  for (int frame = 0; frame < entry.shape().frames; ++frame)
    if (!entry.has(frame) || (options.truth && !options.truth->has(frame))) frames.push_back(frame);
  return render(studio, frames, options, [&](int frame, const std::vector<ScenePicture>& pictures) {
    if (!entry.has(frame)) entry.write(frame, encode(pictures, options.format));
  });
}

std::vector<PictureSet> render_ahead(SceneRenderer& studio, const AheadOptions& options) {
  std::vector<int> frames;
  for (int frame = 0; frame < studio.performance().frames(); ++frame) frames.push_back(frame);
  std::vector<PictureSet> held;
  render(studio, frames, options,
         [&](int, const std::vector<ScenePicture>& pictures) { held.push_back(encode(pictures, options.format)); });
  return held;
}

}  // namespace rotunda::simulator
