#include "rig/cli/clip_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/errors.h"
#include "recon/motion/character.h"
#include "recon/take_studio.h"
#include "rig/cli/command_line.h"
#include "rig/cli/frame_range.h"

namespace rotunda::rig {

namespace fs = std::filesystem;

fs::path find_video(const CommandLine& line, const std::string& clip) {
  if (fs::is_regular_file(clip)) return clip;
  const auto take = find_take(line, clip);
  auto video = recon::geometry_video_of(take);
  if (!fs::exists(video))
    throw InvalidInput(
        fmt::format("take {} is not reconstructed yet; first: rotunda recon {}", take.filename().string(), clip));
  return video;
}

void add_view_dependent(CLI::App& app, ViewDependent& chosen) {
  app.add_flag("--view-dependent", chosen.asked,
               "of a take: in the colours of its own pictures, mixed anew for every viewpoint");
  app.add_option("--calibration", chosen.calibration,
                 "of --view-dependent: what the take was reconstructed with, if not its own");
}

std::shared_ptr<playback::TakePictures> chosen_pictures(const CommandLine& line, const std::string& clip,
                                                        const ViewDependent& chosen) {
  if (chosen.calibration && !chosen.asked)
    throw InvalidInput("--calibration says where the take's cameras stand; it goes with --view-dependent");
  if (!chosen.asked) return nullptr;
  if (std::filesystem::is_regular_file(clip))
    throw InvalidInput(clip +
                       " is a geometry video alone; --view-dependent draws with the pictures of its "
                       "take: name the take instead");
  if (recon::is_character(clip))
    throw InvalidInput(clip + " is a character, which has no pictures of its own; leave --view-dependent out");
  return std::make_shared<playback::TakePictures>(find_take(line, clip), chosen.calibration);
}

std::pair<int, int> chosen_frames(const std::string& range, std::optional<std::size_t> frame,
                                  const recon::GeometryVideoHeader& header) {
  const auto first = static_cast<std::size_t>(header.first_frame);
  const auto end = first + static_cast<std::size_t>(header.frame_count());
  auto chosen = std::pair(first, end);
  if (!range.empty()) chosen = frame_range(range);
  if (frame) chosen = {*frame, *frame + 1};
  chosen.second = std::min(chosen.second, end);
  if (chosen.first < first || chosen.first >= chosen.second)
    throw InvalidInput(
        fmt::format("the geometry video holds the frames {}:{}; none of them are asked for", first, end));
  return {static_cast<int>(chosen.first - first), static_cast<int>(chosen.second - first)};
}

}  // namespace rotunda::rig
