#pragma once
// What a preflight looks at, read from this machine: its links, disk, clock, sensors, the rig's calibration file.
// What cannot be read is left out of the facts, never an error.
#include <functional>

#include "rig/preflight.h"

namespace rotunda::rig {

// Everything but the disk's speed, the renderer and the daemon's status; quick (reads a few small files).
PreflightFacts machine_facts(const std::filesystem::path& takes, const std::optional<config::RigConfig>& rig = {});

struct DiskTrial {
  std::size_t bytes = 200'000'000;                    // written at most, to a file without a name
  std::chrono::milliseconds time{2000};               // and no longer than this, plus what the last flush takes
  std::function<bool()> go_on = [] { return true; };  // asked before each block of 4 MB
};

// Bytes a second that the folder's disk takes, flushed; nothing if it cannot be written, has not twice the room, or the
// trial was ended.
std::optional<double> measure_disk(const std::filesystem::path& folder, const DiskTrial& trial);

}  // namespace rotunda::rig
