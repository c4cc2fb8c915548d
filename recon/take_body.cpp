#include "recon/take_body.h"

#include <algorithm>
#include <utility>

#include "config/errors.h"
#include "recon/frame_store.h"

namespace rotunda::recon {
namespace {

bool has_frames(const BodyTrack& track, const MotionCaptureOptions& options) {
  if (!options.frames) return false;
  return track.first_frame <= options.frames->first && track.first_frame + track.poses.size() >= options.frames->second;
}

std::optional<BodyTrack> kept_track(const MotionCaptureOptions& options) {
  const auto file = joints_file_of(options.take);
  if (!std::filesystem::exists(file)) return std::nullopt;
  auto track = read_joints_json(file);
  if (!has_frames(track, options)) return std::nullopt;
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

std::optional<BodyTrack> body_of_take(const MotionCaptureOptions& options, StageClock& clock, std::stop_token stop) {
  if (const auto kept = kept_track(options)) return steadied(*kept);
  const auto captured = clock.run("skeleton", [&] { return capture_motion(options, {}, std::move(stop)); });
  if (captured.interrupted) return std::nullopt;
  const auto track = track_of(captured.motion);
  if (std::none_of(track.poses.begin(), track.poses.end(), [](const auto& pose) { return pose.has_value(); }))
    throw InvalidInput("the person was lost in every frame");
  write_joints_json(joints_file_of(options.take), captured.motion);
  return steadied(track);
}

}  // namespace rotunda::recon
