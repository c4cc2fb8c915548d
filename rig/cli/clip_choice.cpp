#include "rig/cli/clip_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/errors.h"
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
