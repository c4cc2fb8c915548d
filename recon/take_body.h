#pragma once
// The motion of the person in a take, kept beside its frames (recon/joints.json) so that it is captured once. World,
// metres.
#include <filesystem>
#include <optional>
#include <stop_token>
#include <utility>

#include "recon/body/body_track.h"
#include "recon/stage_clock.h"

namespace rotunda::recon {

std::filesystem::path joints_file_of(const std::filesystem::path& take);

// As the take's own capture measured the person; none if it has no motion yet. Throws CorruptData, std::system_error.
std::optional<BodyTemplate> kept_body_of(const std::filesystem::path& take);

// The motion of the frames asked for, steadied (body_track.h): the motion that is kept if it has them all and the
// measures asked for, else captured and kept. None if interrupted. Throws as TakeOutlines and capture_motion do
// (motion_capture.h), and InvalidInput where the person was lost in every frame.
struct TakeBodyOptions {
  std::filesystem::path take;
  std::optional<std::filesystem::path> calibration;  // else the take's own
  std::pair<std::size_t, std::size_t> frames;        // half-open
  std::optional<BodyTemplate> body;                  // the person's, known from another take
};
std::optional<BodyTrack> body_of_take(const TakeBodyOptions& options, StageClock& clock, std::stop_token stop);

}  // namespace rotunda::recon
