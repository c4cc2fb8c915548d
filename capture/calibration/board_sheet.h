#pragma once
// Boards on paper in true size: the print, rulers along both sides to check it with (printers scale each axis on its
// own), and a line that says what it is. Drawn by cairo.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration/board.h"

namespace rotunda::capture {

// As it lies before the board: width along the board's rows. Metres.
struct PaperSize {
  std::string name;  // "A3", "1200 x 900 mm"
  double width = 0, height = 0;
};

// "A4" to "A0" (turned as fits the board better), or "1200x900" in millimetres. Throws InvalidInput.
PaperSize paper_named(const std::string& name, const Board& board);
// The smallest of A4 to A0 that holds the board. Throws InvalidInput if none does.
PaperSize smallest_paper(const Board& board);

// White around the squares: 10 mm, where the rulers are, beside half a square that finders of chessboards need.
double least_margin(const Board& board);

// The largest squares (whole millimetres; markers 4/5 of them) with which the board's counts fit on a paper "A4" ...
// "A0" or "1200x900". Throws InvalidInput if not even 5 mm do.
Board fitted_to(Board board, const std::string& paper);

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
