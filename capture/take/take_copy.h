#pragma once
// A part of a take as a take of its own: its frames bit for bit, with triggers and times as they were.
#include <filesystem>
#include <stop_token>
#include <utility>

#include "capture/take/take_reader.h"
#include "capture/take/take_verify.h"

namespace rotunda::capture {

struct TakeCopyOptions {
  std::filesystem::path folder;                    // of the new take
  std::pair<std::size_t, std::size_t> frame_sets;  // from, and the first no longer; cut to what there is
};

// Slate, notes, rig, calibration, empty studio, given mattes and journal go with it; what is derived does not. Until it
// is whole it stands under a hidden name, so that no half take is ever listed. Throws InvalidInput (nothing in the
// range, folder exists), std::system_error (no room; operation_canceled when stopped). The original is only read.
TakeInfo copy_take(const TakeReader& take, const TakeCopyOptions& options, const Progress& progress = {},
                   std::stop_token stop = {});

}  // namespace rotunda::capture
