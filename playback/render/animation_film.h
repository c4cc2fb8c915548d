#pragma once
// An animated scan to look at: a film (.mp4), or a sheet of moments in one picture (.png), seen obliquely from the
// front by an eye that follows. Draws headless: no other GL context may be current on this thread.
#include <filesystem>
#include <functional>
#include <stop_token>

#include "recon/deform/scan_animation.h"

namespace rotunda::playback {

struct AnimationFilmOptions {
  std::filesystem::path output;
  double frame_time = 0.04;       // seconds
  int width = 720, height = 720;  // of the film, pixels, even; a sheet's tiles are half as wide as high
  int columns = 6, rows = 2;      // of a sheet
  double azimuth = 0.6;           // of the eye round the performer, radians; 0: from the front (+x)
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::stop_token stop;
};

// `poses`: animation.handle_poses(). Throws InvalidInput, DeviceError (no driver), std::system_error.
void write_animation_film(recon::ScanAnimation& animation, std::span<const recon::HandlePose> poses,
                          const AnimationFilmOptions& options);

}  // namespace rotunda::playback
