#pragma once
// How bright a board's print is, averaged over a small rectangle in the board's frame: exact, by a summed-area table
// over the print's own cells (Crow 1984). 0 black, 1 white; white beyond the squares.
#include <optional>
#include <vector>

#include "capture/calibration/board.h"

namespace rotunda::capture {

class BoardPrint {
 public:
  explicit BoardPrint(const Board& board);

  const Board& board() const { return board_; }
  // The mean over the box about (x, y) with these half sides, metres, all in the board's frame.
  double mean(double x, double y, double half_width, double half_height) const;
  // The colour of all of that box if it is one: it lies within a cell of the print, or beyond its squares.
  std::optional<double> plain(double x, double y, double half_width, double half_height) const;

 private:
  struct Place {
    std::size_t cell;
    double share;  // of the cell
  };
  double black_before(const Place& column,
                      const Place& row) const;  // area of black, squares squared, left of and above
  Place place_of(double squares, int count) const;

  Board board_;
  std::vector<double> edges_;           // of cells within one square, 0 to 1
  std::vector<double> inverse_widths_;  // of the cells
  double marker_scale_ = 1.0;           // cells of the marker in a square's length
  double smallest_cell_ = 1.0;          // area, squares squared
  std::size_t columns_ = 0;             // of the table
  std::vector<double> table_;           // at the cells' corners, row by row
};

}  // namespace rotunda::capture
