#pragma once
// Closes a take whose writer did not: counts what is there and says so in take.yaml (state recovered). The recorded
// files are never touched.
#include <filesystem>

#include "capture/take/take_verify.h"

namespace rotunda::capture {

// A take that is complete keeps its state. Throws InvalidInput if the take is being recorded, and what verify_take
// does.
TakeReport recover_take(const std::filesystem::path& folder, const Progress& progress = {}, std::stop_token stop = {});

}  // namespace rotunda::capture
