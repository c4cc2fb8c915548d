#pragma once
// Papers that boards are printed on: the ISO's and any other, with room for rulers beside the print.
#include <string>

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

double width_of(const Board& board);  // of its squares, metres
double height_of(const Board& board);
bool holds(const PaperSize& paper, const Board& board);  // with its margins

// The largest squares (whole millimetres; markers 4/5 of them) with which the board's counts fit on a paper "A4" ...
// "A0" or "1200x900". Throws InvalidInput if not even 5 mm do.
Board fitted_to(Board board, const std::string& paper);

}  // namespace rotunda::capture
