#pragma once
// Which cameras stood elsewhere in a take than when the empty studio was recorded: its first pictures against the
// background (camera_watch.h). One core, a tenth of a second a camera.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/take/take_reader.h"

namespace rotunda::capture {

struct CameraMove {
  std::string camera;
  std::optional<double> shift_px;  // mean over the picture; nothing: it cannot be told
  bool moved = false;
  std::string how;  // "61 features", "not told: there is no background/cam00.png"
};

// One a camera of the take. `background`: DIR/<camera>.png; empty: the take's own. Throws CorruptData for damaged
// pictures.
std::vector<CameraMove> camera_moves(const TakeReader& take, const std::filesystem::path& background = {});

// A sentence a camera that moved, for whoever records or uses the take: "cam03 has moved by 4.2 px since ...". None for
// a take without a background. What keeps it from being told (a damaged take) is a sentence too; never throws.
std::vector<std::string> moves_in_words(const std::filesystem::path& take);

}  // namespace rotunda::capture
