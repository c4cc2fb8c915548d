#pragma once
// A clip as it is named on the command line, and which of its frames.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "playback/render/take_pictures.h"
#include "recon/video/geometry_video.h"

namespace rotunda::rig {

struct CommandLine;

// A geometry video by its file, or a take's by the take's name or path. Throws InvalidInput: not reconstructed yet.
std::filesystem::path find_video(const CommandLine& line, const std::string& clip);

// Drawing a take in the colours of its cameras' pictures.
struct ViewDependent {
  bool asked = false;
  std::optional<std::filesystem::path> calibration;
};
void add_view_dependent(CLI::App& app, ViewDependent& chosen);
// Nothing if not asked for. Throws InvalidInput for a clip that is no take, or a calibration without the wish.
std::shared_ptr<playback::TakePictures> chosen_pictures(const CommandLine& line, const std::string& clip,
                                                        const ViewDependent& chosen);

// Frames are named by their number in the take (a range A:B, else one frame, else all); the result counts from the
// video's first, half-open. Throws InvalidInput if the video holds none of them.
std::pair<int, int> chosen_frames(const std::string& range, std::optional<std::size_t> frame,
                                  const recon::GeometryVideoHeader& header);

}  // namespace rotunda::rig
