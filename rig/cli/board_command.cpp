// rotunda board: calibration boards on paper, in true size.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/calibration/board_sheet.h"
#include "capture/take/atomic_file.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

using capture::Board;
using capture::BoardType;
namespace fs = std::filesystem;

struct BoardRequest {
  fs::path out, board;                // -o, --board
  std::string charuco, chessboard;    // "6x4" squares, "9x6" inner corners
  double square = 0.0, marker = 0.0;  // metres; 0: chosen
  std::string dictionary = Board{}.dictionary;
  int first_marker = 0, count = 1;
  std::string page;
  double dpi = 300.0;
  bool force = false;
};

std::pair<int, int> counts_in(const std::string& option, const std::string& text) {
  const auto cross = text.find('x');
  int columns = 0, rows = 0;
  const char* end = text.data() + text.size();
  if (cross != std::string::npos &&
      std::from_chars(text.data(), text.data() + cross, columns).ptr == text.data() + cross &&
      std::from_chars(text.data() + cross + 1, end, rows).ptr == end && columns >= 2 && rows >= 2 && columns <= 200 &&
      rows <= 200)
    return {columns, rows};
  throw InvalidInput(fmt::format("{} {}: expected COLUMNSxROWS, as 6x4", option, text));
}

Board wanted_board(const BoardRequest& request) {
  Board board;
  board.dictionary = request.dictionary;
  board.first_marker = request.first_marker;
  if (!request.charuco.empty()) std::tie(board.columns, board.rows) = counts_in("--charuco", request.charuco);
  if (!request.chessboard.empty()) {
    board.type = BoardType::chessboard;
    std::tie(board.columns, board.rows) = counts_in("--chessboard", request.chessboard);
    ++board.columns;
    ++board.rows;
  }
  if (request.square <= 0.0) return capture::fitted_to(board, request.page.empty() ? "A4" : request.page);
  board.square = request.square;
  board.marker = board.type == BoardType::chessboard ? 0.0 : request.marker > 0.0 ? request.marker : 0.8 * board.square;
  return board;
}

std::vector<Board> boards_for(const BoardRequest& request) {
  if (!request.board.empty()) return capture::read_boards(request.board);
  return capture::told_apart(wanted_board(request), request.count);
}

void require_free_places(const BoardRequest& request, const fs::path& yaml) {
  for (const auto& file : {request.out, yaml})
    if (!request.force && fs::exists(file))
      throw InvalidInput(file.string() + " exists already: give another name, or --force to replace it");
}

void tell(const std::vector<Board>& boards, const std::vector<capture::PaperSize>& papers,
          const std::vector<fs::path>& files, const fs::path& yaml, bool as_json) {
  if (as_json) {
    nlohmann::json list = nlohmann::json::array();
    for (std::size_t i = 0; i < boards.size(); ++i)
      list.push_back({{"name", boards[i].name},
                      {"paper", papers[i].name},
                      {"file", files[files.size() > 1 ? i : 0].string()},
                      {"square_mm", boards[i].square * 1e3},
                      {"marker_mm", boards[i].marker * 1e3}});
    fmt::print("{}\n", nlohmann::json{{"boards", list}, {"board_yaml", yaml.string()}}.dump(2));
    return;
  }
  for (std::size_t i = 0; i < boards.size(); ++i)
    fmt::print("{}: {} x {} squares of {:g} mm on {} ({:g} x {:g} mm): {}\n", boards[i].name, boards[i].columns,
               boards[i].rows, boards[i].square * 1e3, papers[i].name, papers[i].width * 1e3, papers[i].height * 1e3,
               files[files.size() > 1 ? i : 0].string());
  fmt::print("print at 100 %, check both rulers, keep {} with it for rotunda calibrate --board\n", yaml.string());
}

int write_boards(const BoardRequest& request, bool as_json) {
  const auto boards = boards_for(request);
  const fs::path own_yaml = fs::path(request.out).replace_extension(".yaml");
  require_free_places(request, request.board.empty() ? own_yaml : request.out);
  std::vector<capture::PaperSize> papers;
  for (const auto& board : boards)
    papers.push_back(request.page.empty() ? capture::smallest_paper(board) : capture::paper_named(request.page, board));
  const auto files = capture::write_board_sheets(request.out, boards, papers, request.dpi);
  if (request.board.empty()) capture::replace_file(own_yaml, capture::board_yaml(boards));
  tell(boards, papers, files, request.board.empty() ? own_yaml : request.board, as_json);
  return kDone;
}

}  // namespace

void add_board_command(CommandLine& line) {
  auto* board = line.app.add_subcommand("board", "calibration boards to print, in true size with rulers");
  auto request = std::make_shared<BoardRequest>();
  board->add_option("-o,--output", request->out, "FILE.pdf, .svg or .png; FILE.yaml is written beside")->required();
  auto* file = board->add_option("--board", request->board, "board.yaml of the boards to print");
  auto* charuco = board->add_option("--charuco", request->charuco, "COLUMNSxROWS squares (else 6x4)")->excludes(file);
  board->add_option("--chessboard", request->chessboard, "COLUMNSxROWS inner corners")
      ->excludes(file)
      ->excludes(charuco);
  board->add_option("--square", request->square, "edge of a square (else as large as the page holds)")
      ->transform(metres())
      ->excludes(file);
  board->add_option("--marker", request->marker, "edge of a marker (else 4/5 of a square)")
      ->transform(metres())
      ->excludes(file);
  board->add_option("--dictionary", request->dictionary, "the markers")
      ->capture_default_str()
      ->check(CLI::IsMember(capture::dictionary_names()))
      ->excludes(file);
  board->add_option("--first-marker", request->first_marker, "number of the first marker")
      ->check(CLI::NonNegativeNumber)
      ->excludes(file);
  board->add_option("--count", request->count, "so many boards, each with markers of its own")
      ->check(CLI::Range(1, 100))
      ->excludes(file);
  board->add_option("--page", request->page, "A4 to A0, or WIDTHxHEIGHT in millimetres (else the smallest that fits)");
  board->add_option("--dpi", request->dpi, "of a .png")->capture_default_str()->check(CLI::Range(20.0, 2400.0));
  board->add_flag("--force", request->force, "replace what is there");
  board->footer(
      "Examples:\n  rotunda board -o board.pdf --page A3\n"
      "  rotunda board -o boards.pdf --charuco 6x4 --square 180mm --marker 144mm --page 1200x840 --count 2");
  board->callback(
      [&line, request] { line.run = [&line, request](std::stop_token) { return write_boards(*request, line.json); }; });
}

}  // namespace rotunda::rig
