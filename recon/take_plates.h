#pragma once
// The empty studio as a take itself shows it, for its cameras without a picture of it (capture/matte/learnt_plate.h):
// learnt once, kept as recon/plates/<camera>.png in the take, which may be deleted. And the live keys that plates make.
#include <filesystem>

#include "capture/take/take_reader.h"
#include "recon/frame_reconstruction.h"

namespace rotunda::recon {

std::filesystem::path learnt_plate_file(const std::filesystem::path& take, const capture::CameraId& camera);

// Fills the empty slots of `studio.backgrounds`; of a take too short, or whose pictures show no screen, a slot stays
// empty. Cameras side by side on oneTBB's threads. Cameras whose mattes came with the take are passed over.
// Throws InvalidInput that names the cameras whose pictures are grey, or all where none shows a screen: nothing tells
// the performer from the studio. std::system_error if a plate cannot be written.
void learn_missing_plates(const capture::TakeReader& take, StudioViews& studio);

// `studio.live_keys`: one for each camera whose plate, its own, learnt or fitted to the take's first picture, shows the
// screen; others are keyed in full.
void make_live_keys(const capture::TakeReader& take, StudioViews& studio);

}  // namespace rotunda::recon
