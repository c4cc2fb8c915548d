#include "recon/take_body.h"

#include <algorithm>
#include <utility>

#include "config/errors.h"
#include "recon/body/motion_capture.h"
#include "recon/frame_store.h"
#include "recon/take_outlines.h"

namespace rotunda::recon {
namespace {

std::optional<BodyTrack> kept_track(const TakeBodyOptions& options) {
  const auto file = joints_file_of(options.take);
  if (!std::filesystem::exists(file)) return std::nullopt;
  auto track = read_joints_json(file);
  const auto [first, end] = options.frames;
  if (track.first_frame > first || track.first_frame + track.poses.size() < end) return std::nullopt;
  if (options.body && track.body.measures != options.body->measures) return std::nullopt;
  return track;
}

}  // namespace

std::filesystem::path joints_file_of(const std::filesystem::path& take) {
  return FrameStore::folder_of(take) / "joints.json";
}

std::optional<BodyTemplate> kept_body_of(const std::filesystem::path& take) {
  const auto file = joints_file_of(take);
  if (!std::filesystem::exists(file)) return std::nullopt;
  return read_joints_json(file).body;
}

std::optional<BodyTrack> body_of_take(const TakeBodyOptions& options, StageClock& clock, std::stop_token stop) {
  if (const auto kept = kept_track(options)) return steadied(*kept);
  const auto captured = clock.run("skeleton", [&] {
    TakeOutlines silhouettes(options.take, options.calibration);
    return capture_motion(silhouettes, {.frames = options.frames, .body = options.body}, {}, std::move(stop));
  });
  if (captured.interrupted) return std::nullopt;
  const auto track = track_of(captured.motion);
  if (std::none_of(track.poses.begin(), track.poses.end(), [](const auto& pose) { return pose.has_value(); }))
    throw InvalidInput("the person was lost in every frame");
  write_joints_json(joints_file_of(options.take), captured.motion);
  return steadied(track);
}

}  // namespace rotunda::recon
