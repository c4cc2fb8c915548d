#pragma once
// A take as pictures: DIR/<camera>/frame000000.png, RGB (mosaics demosaiced), numbered by frame set; the files of
// missing frames are absent.
#include <filesystem>
#include <stop_token>

#include "capture/take/take_verify.h"

namespace rotunda::capture {

class TakeReader;

struct TakeExportResult {
  std::size_t written = 0;  // pictures
  std::size_t missing = 0;  // frames that are not in the take or not readable
};

// Throws std::system_error if a picture cannot be written, operation_canceled when stopped (whole pictures stay).
TakeExportResult export_take(const TakeReader& take, const std::filesystem::path& folder, const Progress& progress = {},
                             std::stop_token stop = {});

}  // namespace rotunda::capture
