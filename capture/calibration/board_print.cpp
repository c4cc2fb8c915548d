#include "capture/calibration/board_print.h"

#include <algorithm>
#include <cmath>

namespace rotunda::capture {
namespace {

// Where a square is cut into cells that are one colour each: at its sides and at the cells of a marker in its middle.
std::vector<double> edges_within_square(const Board& board) {
  std::vector<double> edges{0.0};
  if (board.type == BoardType::charuco) {
    const int cells = marker_cells(board.dictionary, board.first_marker).cols;
    const double side = board.marker / board.square, margin = 0.5 * (1.0 - side);
    for (int i = 0; i <= cells; ++i) edges.push_back(margin + side * i / cells);
  }
  edges.push_back(1.0);
  return edges;
}

// 1 where the print is black, a value a cell.
cv::Mat black_cells(const Board& board, int cells_a_square) {
  cv::Mat black = cv::Mat::zeros(board.rows * cells_a_square, board.columns * cells_a_square, CV_8U);
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (is_black(column, row))
        black(cv::Rect(column * cells_a_square, row * cells_a_square, cells_a_square, cells_a_square)).setTo(1);
  for (const auto& marker : markers_of(board)) {
    const cv::Mat cells = marker_cells(board.dictionary, marker.id) == 0;
    const cv::Rect place(marker.column * cells_a_square + 1, marker.row * cells_a_square + 1, cells.cols, cells.rows);
    black(place).setTo(1, cells);
  }
  return black;
}

}  // namespace

BoardPrint::BoardPrint(const Board& board) : board_(board), edges_(edges_within_square(board)) {
  const int cells = static_cast<int>(edges_.size()) - 1;
  for (std::size_t i = 0; i + 1 < edges_.size(); ++i) inverse_widths_.push_back(1.0 / (edges_[i + 1] - edges_[i]));
  const double widest = *std::max_element(inverse_widths_.begin(), inverse_widths_.end());
  smallest_cell_ = 1.0 / (widest * widest);
  if (cells > 1) marker_scale_ = inverse_widths_[1];
  const cv::Mat black = black_cells(board, cells);
  columns_ = static_cast<std::size_t>(black.cols) + 1;
  table_.assign(columns_ * static_cast<std::size_t>(black.rows + 1), 0.0);
  const auto side = [&](int cell) {
    const auto i = static_cast<std::size_t>(cell % cells);
    return edges_[i + 1] - edges_[i];
  };
  for (int y = 0; y < black.rows; ++y) {
    double row = 0.0;
    for (int x = 0; x < black.cols; ++x) {
      row += black.at<std::uint8_t>(y, x) * side(x) * side(y);
      const auto below = static_cast<std::size_t>(y + 1) * columns_ + static_cast<std::size_t>(x + 1);
      table_[below] = table_[below - columns_] + row;
    }
  }
}

// A marker's cells are equally wide; what is left of the square is one cell on either side.
BoardPrint::Place BoardPrint::place_of(double squares, int count) const {
  const double within = std::clamp(squares, 0.0, static_cast<double>(count));
  const int square = std::min(static_cast<int>(within), count - 1);
  const double rest = within - square;
  const auto cells = static_cast<int>(edges_.size()) - 1;
  int cell = 0;
  if (cells > 1 && rest >= edges_[1])
    cell = std::min(1 + static_cast<int>((rest - edges_[1]) * marker_scale_), cells - 1);
  const auto i = static_cast<std::size_t>(cell);
  return {static_cast<std::size_t>(square * cells + cell), (rest - edges_[i]) * inverse_widths_[i]};
}

// Within a cell the integral is bilinear, so interpolating the table is exact.
double BoardPrint::black_before(const Place& column, const Place& row) const {
  const double u = column.share, v = row.share;
  const double* at = table_.data() + row.cell * columns_ + column.cell;
  return (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[columns_] + u * at[columns_ + 1]);
}

std::optional<double> BoardPrint::plain(double x, double y, double half_width, double half_height) const {
  const double column = x / board_.square + 0.5 * board_.columns, row = 0.5 * board_.rows - y / board_.square;
  const double w = half_width / board_.square, h = half_height / board_.square;
  if (column + w <= 0 || row + h <= 0 || column - w >= board_.columns || row - h >= board_.rows) return 1.0;
  if (column - w < 0 || row - h < 0 || column + w > board_.columns || row + h > board_.rows) return std::nullopt;
  const Place left = place_of(column - w, board_.columns), top = place_of(row - h, board_.rows);
  if (place_of(column + w, board_.columns).cell != left.cell || place_of(row + h, board_.rows).cell != top.cell)
    return std::nullopt;
  const double* at = table_.data() + top.cell * columns_ + left.cell;
  return at[columns_ + 1] - at[columns_] - at[1] + at[0] > 0.5 * smallest_cell_ ? 0.0 : 1.0;
}

double BoardPrint::mean(double x, double y, double half_width, double half_height) const {
  const double column = x / board_.square + 0.5 * board_.columns, row = 0.5 * board_.rows - y / board_.square;
  const double w = half_width / board_.square, h = half_height / board_.square;
  const Place left = place_of(column - w, board_.columns), right = place_of(column + w, board_.columns);
  const Place top = place_of(row - h, board_.rows), bottom = place_of(row + h, board_.rows);
  const double black =
      black_before(right, bottom) - black_before(left, bottom) - black_before(right, top) + black_before(left, top);
  return 1.0 - black / (4.0 * w * h);
}

}  // namespace rotunda::capture
