#pragma once
// Do a take's cameras stand where its calibration says? By the performer's outlines at some of its frames, evenly
// spread (hull/camera_agreement.h): for a studio whose plain walls show nothing that could be found again.
#include <stop_token>
#include <vector>

#include "capture/take/take_reader.h"
#include "recon/camera_standing.h"
#include "recon/frame_reconstruction.h"

namespace rotunda::recon {

// One a camera of the take. By the live key, as its outlines are as true and cost less; frames side by side on oneTBB's
// threads. Throws CorruptData.
std::vector<CameraStanding> camera_standings(const capture::TakeReader& take, const StudioViews& studio,
                                             const std::stop_token& stop = {});

}  // namespace rotunda::recon
