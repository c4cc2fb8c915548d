#pragma once
// The way back from an archived take (take_archive.h).
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/take/take_verify.h"

namespace rotunda::capture {

// The take in `folder` as it was recorded: every file has the SHA-256 it had (take.yaml may have been edited since).
// Throws CorruptData that lists what has changed in the archive, and leaves nothing then; else as archive_take.
TakeInfo restore_take(const std::filesystem::path& archive, const std::filesystem::path& folder,
                      const Progress& progress = {}, std::stop_token stop = {});

// Which of an archive's files are not as they were written, to the last bit.
std::vector<std::string> archive_problems(const std::filesystem::path& archive);

}  // namespace rotunda::capture
