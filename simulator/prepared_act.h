#pragma once
// An act ready to be played before the cameras: out of the frame cache if it was rendered before, else rendered now.
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>

#include "simulator/studio/act_player.h"
#include "simulator/studio/render_ahead.h"

namespace rotunda::simulator {

struct ActOptions {
  PerformanceOptions performance;
  std::vector<capture::CameraModel> cameras;
  SensorOptions sensor;
  BackdropOptions backdrop;
  capture::PixelFormat format = capture::PixelFormat::bayer_rg8;
  std::optional<FrameCache::Options> cache;     // nothing: pictures are rendered every time and held in memory
  std::optional<std::filesystem::path> truth;   // folder to write what is true of the act to
  std::uint64_t most_held_bytes = 250'000'000;  // longer acts are streamed from the cache
  AheadProgress progress;
  std::stop_token stop;
};

// Nothing if stopped before it was ready: what was rendered stays in the cache. With a whole cache and no truth asked
// for, nobody is made and no graphics context opened. Throws as make_performance, FrameCache and TruthFiles do.
std::unique_ptr<ActPlayer> prepare_act(const ActOptions& options);

}  // namespace rotunda::simulator
