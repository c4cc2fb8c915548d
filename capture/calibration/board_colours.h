#pragma once
// The white of a board as a grey card: what each camera makes of the same white places of the print, wherever the board
// was held, for colour_match.h. Places are cells of a lattice over the board at one moment; the paper is taken to be
// matt and of one white.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "capture/calibration/board_detector.h"
#include "capture/calibration/colour_match.h"

namespace rotunda::capture {

// White places of one board in one picture (CV_8UC3, RGB) that are neither clipped nor dark, and far enough from ink
// that no blur brings it in. Their numbers run from `first_place` on, places_of(board) in all.
std::vector<ColourSample> white_samples(const cv::Mat& rgb, const BoardPrint& print, const FoundBoard& found,
                                        std::size_t camera, std::size_t first_place);
std::size_t places_of(const Board& board);

struct BoardColours {
  std::vector<std::string> cameras;
  std::vector<ColourSample> samples;
  std::size_t pictures = 0;  // with a board
};

// Of a folder of pictures as board_folder.h has them. Throws InvalidInput for pictures without colour, naming one, or
// if no board is found in any.
BoardColours colours_of_boards(const std::filesystem::path& folder, const std::vector<Board>& boards,
                               const std::function<void(std::size_t done, std::size_t total)>& progress = {});

}  // namespace rotunda::capture
