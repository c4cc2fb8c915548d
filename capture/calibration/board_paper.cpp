#include "capture/calibration/board_paper.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kRulerMargin = 0.010;  // metres: ticks, their numbers, and what printers leave white
constexpr double kLongestPaper = 10.0;  // metres

// ISO 216, lying: the long side across.
const std::array<PaperSize, 5>& iso_papers() {
  static const std::array<PaperSize, 5> kPapers = {PaperSize{"A4", 0.297, 0.210}, PaperSize{"A3", 0.420, 0.297},
                                                   PaperSize{"A2", 0.594, 0.420}, PaperSize{"A1", 0.841, 0.594},
                                                   PaperSize{"A0", 1.189, 0.841}};
  return kPapers;
}

PaperSize turned(PaperSize paper) {
  std::swap(paper.width, paper.height);
  return paper;
}

std::optional<PaperSize> custom_paper(const std::string& name) {
  const auto cross = name.find('x');
  if (cross == std::string::npos) return std::nullopt;
  double width = 0, height = 0;
  const char* end = name.data() + name.size();
  if (std::from_chars(name.data(), name.data() + cross, width).ptr != name.data() + cross ||
      std::from_chars(name.data() + cross + 1, end, height).ptr != end || !(width > 0 && height > 0) ||
      !(std::max(width, height) <= kLongestPaper * 1e3))
    return std::nullopt;
  return PaperSize{fmt::format("{:g} x {:g} mm", width, height), width * 1e-3, height * 1e-3};
}

}  // namespace

double width_of(const Board& board) {
  return board.columns * board.square;
}
double height_of(const Board& board) {
  return board.rows * board.square;
}

bool holds(const PaperSize& paper, const Board& board) {
  constexpr double kRounding = 1e-9;
  return paper.width + kRounding >= width_of(board) + 2 * least_margin(board) &&
         paper.height + kRounding >= height_of(board) + 2 * least_margin(board);
}

double least_margin(const Board& board) {
  return kRulerMargin + (board.type == BoardType::chessboard ? board.square / 2 : 0.0);
}

PaperSize paper_named(const std::string& name, const Board& board) {
  for (const auto& paper : iso_papers())
    if (paper.name == name) return holds(paper, board) || !holds(turned(paper), board) ? paper : turned(paper);
  if (const auto paper = custom_paper(name)) return *paper;
  throw InvalidInput("--page " + name + ": expected A4, A3, A2, A1, A0 or WIDTHxHEIGHT in millimetres (at most 10 m)");
}

PaperSize smallest_paper(const Board& board) {
  for (const auto& paper : iso_papers())
    for (const auto& way : {paper, turned(paper)})
      if (holds(way, board)) return way;
  throw InvalidInput(fmt::format("{} of {:g} x {:g} mm fits on no paper up to A0: say --page WIDTHxHEIGHT (mm)",
                                 board.name, width_of(board) * 1e3, height_of(board) * 1e3));
}

Board fitted_to(Board board, const std::string& paper) {
  for (int mm = 1000; mm >= 5; --mm) {
    board.square = mm * 1e-3;
    board.marker = board.type == BoardType::charuco ? 0.8 * board.square : 0.0;
    if (holds(paper_named(paper, board), board)) return board;
  }
  throw InvalidInput(fmt::format("{} x {} squares do not fit on {}", board.columns, board.rows, paper));
}

}  // namespace rotunda::capture
