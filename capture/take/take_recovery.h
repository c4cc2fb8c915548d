#pragma once
// Closes a take whose writer did not: counts what is there and says so in take.yaml (state recovered). The recorded
// files are never touched. A take.yaml that is lost or cannot be read is made anew from the cameras' files (cameras by
// name; slate, note and rig are lost with it); the unreadable one is kept as take.yaml.broken.
#include <filesystem>

#include "capture/take/take_verify.h"

namespace rotunda::capture {

// A take that is complete keeps its state. Throws InvalidInput if the take is being recorded or the folder holds no
// take, and what verify_take does.
TakeReport recover_take(const std::filesystem::path& folder, const Progress& progress = {}, std::stop_token stop = {});

}  // namespace rotunda::capture
