#include "capture/calibration/board.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <opencv2/aruco.hpp>
#include <optional>
#include <utility>

#include "config/checked_yaml.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using config::CheckedMap;
using config::Problems;

constexpr std::array kDictionaries = {std::pair{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
                                      std::pair{"DICT_4X4_100", cv::aruco::DICT_4X4_100},
                                      std::pair{"DICT_4X4_250", cv::aruco::DICT_4X4_250},
                                      std::pair{"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
                                      std::pair{"DICT_5X5_50", cv::aruco::DICT_5X5_50},
                                      std::pair{"DICT_5X5_100", cv::aruco::DICT_5X5_100},
                                      std::pair{"DICT_5X5_250", cv::aruco::DICT_5X5_250},
                                      std::pair{"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
                                      std::pair{"DICT_6X6_50", cv::aruco::DICT_6X6_50},
                                      std::pair{"DICT_6X6_100", cv::aruco::DICT_6X6_100},
                                      std::pair{"DICT_6X6_250", cv::aruco::DICT_6X6_250},
                                      std::pair{"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
                                      std::pair{"DICT_7X7_50", cv::aruco::DICT_7X7_50},
                                      std::pair{"DICT_7X7_100", cv::aruco::DICT_7X7_100},
                                      std::pair{"DICT_7X7_250", cv::aruco::DICT_7X7_250},
                                      std::pair{"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
                                      std::pair{"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
                                      std::pair{"DICT_APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
                                      std::pair{"DICT_APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
                                      std::pair{"DICT_APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
                                      std::pair{"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11}};
constexpr int kMostSquares = 200;       // a side
constexpr double kLongestSquare = 2.0;  // metres
constexpr double kShortestSquare = 0.001;

cv::Ptr<cv::aruco::Dictionary> find_dictionary(const std::string& name) {
  for (const auto& [known, number] : kDictionaries)
    if (name == known) return cv::aruco::getPredefinedDictionary(number);
  return {};
}

// What keeps a single board from being printed or found: (key, message), or nothing.
std::optional<std::pair<std::string, std::string>> flaw_of(const Board& board) {
  if (board.type == BoardType::chessboard) return std::nullopt;
  const auto dictionary = find_dictionary(board.dictionary);
  if (!dictionary) {
    const auto names = dictionary_names();
    return std::pair{"dictionary", fmt::format("there is no {}; is {} meant?", board.dictionary,
                                               config::nearest_word(board.dictionary, {names.begin(), names.end()}))};
  }
  if (!(board.marker < board.square && board.marker > 0.0))
    return std::pair{"marker_mm", fmt::format("a marker stands inside its square: expected less than {:g}, found {:g}",
                                              board.square * 1e3, board.marker * 1e3)};
  const int wanted = board.first_marker + board.columns * board.rows / 2, there = dictionary->bytesList.rows;
  if (board.first_marker < 0 || wanted > there)
    return std::pair{"first_marker", fmt::format("{} has the markers 0 to {}; this board wants {} to {}",
                                                 board.dictionary, there - 1, board.first_marker, wanted - 1)};
  return std::nullopt;
}

bool can_be_told_apart(const Board& a, const Board& b) {
  if (a.type != b.type) return true;
  if (a.type == BoardType::chessboard) return std::minmax(a.columns, a.rows) != std::minmax(b.columns, b.rows);
  if (a.dictionary != b.dictionary) return true;
  const int a_end = a.first_marker + a.columns * a.rows / 2, b_end = b.first_marker + b.columns * b.rows / 2;
  return a_end <= b.first_marker || b_end <= a.first_marker;
}

// Of several boards: (number of the later one, message), or nothing.
std::optional<std::pair<std::size_t, std::string>> confusion_among(std::span<const Board> boards) {
  for (std::size_t later = 0; later < boards.size(); ++later)
    for (std::size_t earlier = 0; earlier < later; ++earlier) {
      if (boards[later].name == boards[earlier].name)
        return std::pair{later, fmt::format("there is a board {} already; give each a name", boards[later].name)};
      if (!can_be_told_apart(boards[earlier], boards[later]))
        return std::pair{later,
                         fmt::format("cannot be told from {} in a picture: ChArUco boards of one dictionary need "
                                     "markers of their own (first_marker), chessboards another number of corners",
                                     boards[earlier].name)};
    }
  return std::nullopt;
}

void read_counts(CheckedMap& map, const std::string& key, int beyond, Board& board) {
  std::array<int, 2> counts{};
  map.require(key, "[columns, rows]");
  map.read<std::array<int, 2>>(
      key, counts, fmt::format("[columns, rows], each 2 to {}", kMostSquares), [](const auto& sides) {
        return std::all_of(sides.begin(), sides.end(), [](int side) { return side >= 2 && side <= kMostSquares; });
      });
  board.columns = counts[0] + beyond;
  board.rows = counts[1] + beyond;
}

void read_length(CheckedMap& map, const std::string& key, double& metres) {
  double millimetres = 0.0;
  map.require(key, "a length in millimetres, measured on the print");
  map.read<double>(key, millimetres, "millimetres, 1 to 2000",
                   [](double mm) { return mm >= kShortestSquare * 1e3 && mm <= kLongestSquare * 1e3; });
  metres = millimetres * 1e-3;
}

std::string type_of(CheckedMap& map) {
  std::string type;
  map.require("type", "charuco or chessboard");
  map.read<std::string>("type", type, "charuco or chessboard",
                        [](const std::string& word) { return word == "charuco" || word == "chessboard"; });
  return type;
}

Board read_board(const YAML::Node& node, const std::string& path, std::string name, Problems& problems) {
  CheckedMap map(node, path, problems);
  const std::size_t before = problems.size();
  Board board;
  board.name = std::move(name);
  map.read<std::string>("name", board.name, "a name", [](const std::string& word) { return !word.empty(); });
  const auto type = type_of(map);
  if (type == "charuco") {
    read_counts(map, "squares", 0, board);
    read_length(map, "square_mm", board.square);
    read_length(map, "marker_mm", board.marker);
    map.require("dictionary", "one of OpenCV's, as DICT_4X4_50");
    map.read<std::string>("dictionary", board.dictionary, "one of OpenCV's, as DICT_4X4_50");
    map.read<int>("first_marker", board.first_marker, "a marker's number, from 0", [](int id) { return id >= 0; });
  } else if (type == "chessboard") {
    board.type = BoardType::chessboard;
    board.marker = 0.0;
    read_counts(map, "inner_corners", 1, board);
    read_length(map, "square_mm", board.square);
  }
  if (!type.empty()) map.refuse_unknown_keys();
  if (problems.size() == before)
    if (const auto flaw = flaw_of(board)) {
      const auto mark = node.Mark();
      problems.push_back({mark.line + 1, mark.column + 1, map.path_of(flaw->first), flaw->second});
    }
  return board;
}

std::vector<Board> boards_in(const YAML::Node& root, Problems& problems) {
  if (!root.IsMap() || !root["boards"]) return {read_board(root, "", "board", problems)};
  CheckedMap map(root, "", problems);
  const YAML::Node list = map.find("boards");
  map.refuse_unknown_keys();
  if (!list.IsSequence() || list.size() == 0) {
    map.wrong(list, "boards", "a list of boards");
    return {};
  }
  std::vector<Board> boards;
  for (std::size_t i = 0; i < list.size(); ++i)
    boards.push_back(read_board(list[i], fmt::format("boards[{}]", i), fmt::format("board{}", i), problems));
  if (!problems.empty()) return boards;
  if (const auto confusion = confusion_among(boards)) {
    const auto mark = list[confusion->first].Mark();
    problems.push_back(
        {mark.line + 1, mark.column + 1, fmt::format("boards[{}]", confusion->first), confusion->second});
  }
  return boards;
}

Eigen::Vector2d corner_of_square(const Board& board, int column, int row) {
  return {(column - 0.5 * board.columns) * board.square, (0.5 * board.rows - row) * board.square};
}

Eigen::AlignedBox2d rectangle(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  Eigen::AlignedBox2d box(a);
  box.extend(b);
  return box;
}

// Runs of black cells of one row, so that few rectangles do.
void append_marker(const Board& board, const BoardMarker& marker, std::vector<Eigen::AlignedBox2d>& rectangles) {
  const cv::Mat cells = marker_cells(board.dictionary, marker.id);
  const double edge = board.marker / cells.cols;
  const Eigen::Vector3d upper_left = marker_corners(board, marker)[0];
  const auto at = [&](int x, int y) { return Eigen::Vector2d(upper_left.x() + x * edge, upper_left.y() - y * edge); };
  for (int y = 0; y < cells.rows; ++y)
    for (int x = 0, end = 0; x < cells.cols; x = end + 1) {
      for (end = x; end < cells.cols && cells.at<std::uint8_t>(y, end) == 0;) ++end;
      if (end > x) rectangles.push_back(rectangle(at(x, y), at(end, y + 1)));
    }
}

}  // namespace

int corner_count(const Board& board) {
  return (board.columns - 1) * (board.rows - 1);
}

std::vector<Eigen::Vector3d> corner_positions(const Board& board) {
  std::vector<Eigen::Vector3d> corners;
  for (int row = 1; row < board.rows; ++row)
    for (int column = 1; column < board.columns; ++column) {
      const Eigen::Vector2d at = corner_of_square(board, column, row);
      corners.emplace_back(at.x(), at.y(), 0.0);
    }
  return corners;
}

bool is_black(int column, int row) {
  return (column + row) % 2 == 0;
}

std::vector<BoardMarker> markers_of(const Board& board) {
  std::vector<BoardMarker> markers;
  if (board.type == BoardType::chessboard) return markers;
  int id = board.first_marker;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (!is_black(column, row)) markers.push_back({id++, column, row});
  return markers;
}

std::array<Eigen::Vector3d, 4> marker_corners(const Board& board, const BoardMarker& marker) {
  const double margin = 0.5 * (board.square - board.marker), m = board.marker;
  const Eigen::Vector2d square = corner_of_square(board, marker.column, marker.row);
  const Eigen::Vector3d upper_left(square.x() + margin, square.y() - margin, 0.0);
  return {upper_left, upper_left + Eigen::Vector3d(m, 0, 0), upper_left + Eigen::Vector3d(m, -m, 0),
          upper_left + Eigen::Vector3d(0, -m, 0)};
}

bool looks_the_same_upside_down(const Board& board) {
  return board.type == BoardType::chessboard && (board.columns + board.rows) % 2 == 0;
}

std::vector<Eigen::AlignedBox2d> black_rectangles(const Board& board) {
  std::vector<Eigen::AlignedBox2d> rectangles;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (is_black(column, row))
        rectangles.push_back(
            rectangle(corner_of_square(board, column, row), corner_of_square(board, column + 1, row + 1)));
  for (const auto& marker : markers_of(board)) append_marker(board, marker, rectangles);
  return rectangles;
}

cv::Mat marker_cells(const std::string& dictionary, int id) {
  const auto known = find_dictionary(dictionary);
  if (!known) throw InvalidInput("there is no dictionary " + dictionary);
  if (id < 0 || id >= known->bytesList.rows)
    throw InvalidInput(fmt::format("{} has no marker {}: it has 0 to {}", dictionary, id, known->bytesList.rows - 1));
  cv::Mat cells;
  known->drawMarker(id, known->markerSize + 2, cells, 1);
  return cells;
}

std::vector<std::string> dictionary_names() {
  std::vector<std::string> names;
  for (const auto& [name, number] : kDictionaries) names.emplace_back(name);
  return names;
}

std::vector<Board> read_boards(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file))
    throw ConfigError(file, {{0, 0, "", "cannot be opened; does the file exist, and may it be read?"}});
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  Problems problems;
  std::vector<Board> boards;
  try {
    boards = boards_in(YAML::Load(text), problems);
  } catch (const YAML::Exception& error) {
    problems.push_back({error.mark.line + 1, error.mark.column + 1, "", "is no YAML here: " + error.msg});
  }
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  return boards;
}

int dictionary_number(const std::string& name) {
  for (const auto& [known, number] : kDictionaries)
    if (name == known) return number;
  throw InvalidInput("there is no dictionary " + name);
}

void check_boards(std::span<const Board> boards) {
  for (const auto& board : boards)
    if (const auto flaw = flaw_of(board)) throw InvalidInput(board.name + ": " + flaw->second);
  if (const auto confusion = confusion_among(boards))
    throw InvalidInput(boards[confusion->first].name + ": " + confusion->second);
}

}  // namespace rotunda::capture
