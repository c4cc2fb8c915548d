#pragma once
// Rims (hull/rims.h) at live quality: of outline points about a cell apart, in single precision. World frame and units.
// The same on any number of threads.
#include <span>
#include <vector>

#include "recon/hull/rims.h"
#include "recon/live/live_silhouette.h"

namespace rotunda::recon {

// `options.stride`: every so manieth crossing of the outline with the lines between pixel centres.
std::vector<Rim> live_rims(std::span<const LiveSilhouette> views, const RimOptions& options);

}  // namespace rotunda::recon
