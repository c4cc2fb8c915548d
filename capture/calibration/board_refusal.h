#pragma once
// What no calibration can begin without, and what the pictures show instead: refused in words that say what to do.
#include "capture/calibration/board_search.h"

namespace rotunda::capture {

// Throws InvalidInput: one camera only.
void refuse_too_little(std::size_t cameras);

// Throws InvalidInput where no camera saw the board often enough: another board, a mirrored one, or none at all. Few
// markers of a board that is not there are found by chance. Looks at a few pictures only.
void refuse_another_board(const BoardSearch& search, const BoardPictures& pictures, const CalibrateOptions& options);

// Throws InvalidInput where the world shall be that of a camera of which there are no pictures.
void refuse_another_world(std::span<const std::string> cameras, const std::string& world_from);

// Why a camera saw too few boards, for those that did and whose pictures tell: mirrored, another board. A text a
// camera, empty where there is none.
std::vector<std::string> why_unseen(const BoardSearch& search, const BoardPictures& pictures,
                                    const CalibrateOptions& options);

}  // namespace rotunda::capture
