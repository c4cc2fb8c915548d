#pragma once
// An archived take: the same folder with the cameras' pixels compressed without loss (FFV1 on split mosaics), read by
// TakeReader like any other, and with what it takes to make the recorded files again to the last bit.
// docs/take-format.md describes it.
#include <cstdint>
#include <filesystem>
#include <stop_token>

#include "capture/take/take_verify.h"

namespace rotunda::capture {

struct TakeArchiveResult {
  std::size_t frames = 0;          // of all cameras, each decoded again and compared
  std::size_t damaged = 0;         // of these, those whose pixels were not as recorded before: kept as they were
  std::uint64_t bytes_before = 0;  // of all files but what is derived (recon/)
  std::uint64_t bytes_after = 0;
};

// Makes `archive` of the take in `take`, which is only read and should be kept until the archive has a copy. Everything
// but recon/ goes with it. Then the recorded files are made again out of what was written and compared by SHA-256.
// Until that is done it stands under a hidden name: there is never half an archive. `progress` counts frames, twice.
// Throws InvalidInput (not closed, an archive already, `archive` exists), std::system_error (no room; disk fails;
// operation_canceled when stopped), CorruptData if what was written is not what was read back.
TakeArchiveResult archive_take(const std::filesystem::path& take, const std::filesystem::path& archive,
                               const Progress& progress = {}, std::stop_token stop = {});

}  // namespace rotunda::capture
