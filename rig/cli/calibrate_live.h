#pragma once
// rotunda calibrate --live: pictures of boards from the running rig while somebody walks with the board; what each
// camera still needs is shown, and the calibration follows when every camera has enough.
#include <filesystem>
#include <stop_token>
#include <vector>

#include "capture/calibration/calibrate.h"

namespace rotunda::rig {

struct LiveBoards {
  capture::BoardPictures pictures;  // the moments that were kept, in memory
  bool enough = false;              // false: ended by the operator
};

// Records takes of one frame set, one after the other, looks at each and deletes it. `keep`: a folder for the pictures
// (DIR/<camera>/<moment>.png), empty: none. A stop request ends the walk. Throws DeviceError if the daemon does not
// answer, InvalidInput if no picture came.
LiveBoards walk_with_board(const std::filesystem::path& daemon, const std::vector<capture::Board>& boards,
                           const std::filesystem::path& keep, const std::stop_token& stop);

}  // namespace rotunda::rig
