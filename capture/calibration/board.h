#pragma once
// A calibration board and its print: ChArUco (Garrido-Jurado et al. 2014, OpenCV 4.6's layout: the upper left square is
// black, markers stand in the white squares and are numbered row by row from the top) or a plain chessboard.
// Board frame: metres, origin at the middle of the printed squares, x to the right and y up as one reads it, z out of
// the face. Columns and rows of squares and corners count from the upper left.
// board.yaml holds one board, or several under `boards:`
//   type: charuco      squares: [6, 4]  square_mm: 180  marker_mm: 144  dictionary: DICT_4X4_50  first_marker: 0
//   type: chessboard   inner_corners: [9, 6]  square_mm: 100
// Each may have a `name`, and `first_marker` may be left out.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

namespace rotunda::capture {

enum class BoardType { charuco, chessboard };

struct Board {
  std::string name = "board";
  BoardType type = BoardType::charuco;
  int columns = 6, rows = 4;  // squares; a chessboard of 9 x 6 inner corners has 10 x 7
  double square = 0.180;      // edge, metres
  double marker = 0.144;      // edge, metres; 0 for a chessboard
  std::string dictionary = "DICT_4X4_50";
  int first_marker = 0;  // boards that are shown together share a dictionary and differ in their markers
};

// A marker of a ChArUco board: its number in the dictionary and the square it stands in.
struct BoardMarker {
  int id = 0;
  int column = 0, row = 0;
};

// The inner corners by their number, row by row from the upper left one (as OpenCV 4.6 numbers them).
int corner_count(const Board& board);
std::vector<Eigen::Vector3d> corner_positions(const Board& board);
std::vector<BoardMarker> markers_of(const Board& board);  // none on a chessboard
// Upper left, upper right, lower right, lower left, as detectors give them.
std::array<Eigen::Vector3d, 4> marker_corners(const Board& board, const BoardMarker& marker);
bool is_black(int column, int row);  // of a square: (column + row) even
// The same print turned by half a turn: its pictures do not tell which is which (a chessboard whose sides add up even).
bool looks_the_same_upside_down(const Board& board);

// Everything that is printed black, as rectangles in the board's x, y that do not overlap: black squares, then the
// markers' black cells. What is not black is white, also a margin of at least half a square around.
std::vector<Eigen::AlignedBox2d> black_rectangles(const Board& board);

// CV_8UC1, 0 black and 255 white; one pixel is one cell, the black rim of one cell included.
cv::Mat marker_cells(const std::string& dictionary, int id);
std::vector<std::string> dictionary_names();
int dictionary_number(const std::string& name);  // OpenCV's; throws InvalidInput for an unknown name

// The boards of a file. Throws ConfigError with every mistake: unknown dictionary, markers that do not fit or run out,
// boards that cannot be told apart.
std::vector<Board> read_boards(const std::filesystem::path& file);
// As above for boards from several files, or made by a program: throws InvalidInput.
void check_boards(std::span<const Board> boards);

}  // namespace rotunda::capture
