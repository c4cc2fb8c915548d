#pragma once
// Boards on paper in true size: the print, rulers along both sides to check it with (printers scale each axis on its
// own), and a line that says what it is. Drawn by cairo.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration/board_paper.h"

namespace rotunda::capture {

// N boards that can be told apart: ChArUco boards with markers of their own, named board0, board1, ... Throws
// InvalidInput if the dictionary has too few markers, or for several chessboards.
std::vector<Board> told_apart(const Board& board, int count);

std::string board_yaml(std::span<const Board> boards);

// Writes FILE.pdf (a page a board), or FILE.svg, FILE.png (one file a board, FILE-NAME.png where there are several).
// Returns the files. `dpi` is of PNG pictures, and noted in them. Throws InvalidInput for a board that its paper does
// not hold or another ending, std::system_error if a file cannot be written.
std::vector<std::filesystem::path> write_board_sheets(const std::filesystem::path& file, std::span<const Board> boards,
                                                      std::span<const PaperSize> papers, double dpi = 300.0);

}  // namespace rotunda::capture
