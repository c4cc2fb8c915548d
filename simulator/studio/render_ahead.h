#pragma once
// Rendering the pictures of an act before they are played, and the truth about them.
#include <functional>
#include <stop_token>

#include "simulator/studio/frame_cache.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {

class TruthFiles;

// Told the number of act frames done and of all to do; first with none done.
using AheadProgress = std::function<void(int done, int all)>;

struct AheadOptions {
  capture::PixelFormat format = capture::PixelFormat::bayer_rg8;
  const TruthFiles* truth = nullptr;  // writes the truth of every act frame that has none yet, too
  AheadProgress progress;
  std::stop_token stop;
};

// What the cameras send of one act frame.
PictureSet encode(const std::vector<ScenePicture>& pictures, capture::PixelFormat format);

// Bytes of what each camera sends.
EntryShape shape_of(const std::vector<capture::CameraModel>& cameras, int frames, capture::PixelFormat format);

// Renders the frames that `entry` or the truth has not; on the renderer's thread. False if stopped before the end: what
// is done stays.
bool render_ahead(SceneRenderer& studio, CacheEntry& entry, const AheadOptions& options);

// The same into memory; fewer frames than the act has if stopped.
std::vector<PictureSet> render_ahead(SceneRenderer& studio, const AheadOptions& options);

}  // namespace rotunda::simulator
