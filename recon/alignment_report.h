#pragma once
// What alignment found out about a take's frames, as JSON (recon/aligned/report.json, and a file a frame).
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "recon/take_alignment.h"

namespace rotunda::recon {

nlohmann::json json_of(const FrameAlignment& frame);

// Throws CorruptData that names the folder.
FrameAlignment frame_alignment_of(const std::string& text, const std::filesystem::path& folder);

}  // namespace rotunda::recon
