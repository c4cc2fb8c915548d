#include "capture/calibration/board_sheet.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "capture/take/atomic_file.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr double kPointsPerMetre = 72.0 / 0.0254;
constexpr double kTextHeight = 0.0025;

struct EndSurface {
  void operator()(cairo_surface_t* surface) const noexcept { cairo_surface_destroy(surface); }
};
struct EndDrawing {
  void operator()(cairo_t* drawing) const noexcept { cairo_destroy(drawing); }
};
using Surface = std::unique_ptr<cairo_surface_t, EndSurface>;
using Drawing = std::unique_ptr<cairo_t, EndDrawing>;

void require_success(cairo_status_t status, const fs::path& file) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw std::system_error(std::make_error_code(std::errc::io_error),
                          "cannot write " + file.string() + ": " + cairo_status_to_string(status));
}

// Draws in metres, from the paper's upper left corner.
class Sheet {
 public:
  Sheet(cairo_t* drawing, const Board& board, const PaperSize& paper)
      : cr_(drawing),
        board_(board),
        left_((paper.width - width_of(board)) / 2),
        top_((paper.height - height_of(board)) / 2) {}

  void draw() {
    print();
    ruler(left_, top_ + height_of(board_), width_of(board_), false);
    ruler(left_, top_, height_of(board_), true);
    caption();
  }

 private:
  // One path: what lies side by side leaves no hairline between.
  void print() {
    cairo_new_path(cr_);
    for (const auto& box : black_rectangles(board_)) {
      const double x = left_ + width_of(board_) / 2 + box.min().x(), y = top_ + height_of(board_) / 2 - box.max().y();
      cairo_rectangle(cr_, x, y, box.sizes().x(), box.sizes().y());
    }
    cairo_fill(cr_);
  }

  // Ticks a millimetre apart, numbers every 10 mm or, on long ones, every 50; outside of the print.
  void ruler(double x, double y, double length, bool down) {
    const int millimetres = static_cast<int>(std::floor(length * 1e3 + 1e-6));
    const double direction = down ? -1.0 : 1.0;  // away from the print
    const int numbered = millimetres > 400 ? 50 : 10;
    cairo_set_line_width(cr_, 0.00015);
    for (int mm = 0; mm <= millimetres; ++mm) {
      const double tick = mm % 10 == 0 ? 0.0035 : mm % 5 == 0 ? 0.0025 : 0.0015, along = mm * 1e-3, gap = 0.0015;
      const double from_x = down ? x - gap : x + along, from_y = down ? y + along : y + gap;
      cairo_move_to(cr_, from_x, from_y);
      cairo_rel_line_to(cr_, down ? direction * tick : 0.0, down ? 0.0 : direction * tick);
    }
    cairo_stroke(cr_);
    for (int mm = 0; mm <= millimetres; mm += numbered) number(x, y, mm, down);
  }

  // The unit stands with the first number, which begins at its tick; the others have their middle there.
  void number(double x, double y, int mm, bool down) {
    const auto text = fmt::format("{}{}", mm, mm == 0 ? " mm" : "");
    const double width = text_width(text), along = mm * 1e-3;
    if (!down) return write(text, x + along - (mm == 0 ? 0.0 : width / 2), y + 0.0055 + kTextHeight, 0.0);
    write(text, x - 0.0055, y + along + (mm == 0 ? width : width / 2), -M_PI / 2);
  }

  void caption() {
    const auto what = board_.type == BoardType::charuco
                          ? fmt::format("{}: ChArUco, {} x {} squares of {:g} mm, markers {:g} mm, {} from {}",
                                        board_.name, board_.columns, board_.rows, board_.square * 1e3,
                                        board_.marker * 1e3, board_.dictionary, board_.first_marker)
                          : fmt::format("{}: chessboard, {} x {} inner corners, squares of {:g} mm", board_.name,
                                        board_.columns - 1, board_.rows - 1, board_.square * 1e3);
    const std::string check =
        "Print at 100 % (not \"fit to page\"), glue it to something flat, check both rulers; if they are off, write "
        "the "
        "measured square_mm into board.yaml.";
    write_fitted(what, top_ - 0.0055);
    write_fitted(check, top_ - 0.0020);
  }

  // Shrunk where the board is narrow.
  void write_fitted(const std::string& text, double y) {
    const double width = text_width(text), scale = std::min(1.0, width_of(board_) / width);
    cairo_set_font_size(cr_, kTextHeight * scale);
    cairo_move_to(cr_, left_, y);
    cairo_show_text(cr_, text.c_str());
  }

  double text_width(const std::string& text) {
    cairo_set_font_size(cr_, kTextHeight);
    cairo_text_extents_t extents;
    cairo_text_extents(cr_, text.c_str(), &extents);
    return extents.x_advance;
  }

  void write(const std::string& text, double x, double y, double angle) {
    cairo_set_font_size(cr_, kTextHeight);
    cairo_save(cr_);
    cairo_move_to(cr_, x, y);
    cairo_rotate(cr_, angle);
    cairo_show_text(cr_, text.c_str());
    cairo_restore(cr_);
  }

  cairo_t* cr_;
  const Board& board_;
  double left_, top_;  // of the print
};

void draw_sheet(cairo_surface_t* surface, double units_per_metre, const Board& board, const PaperSize& paper) {
  const Drawing drawing(cairo_create(surface));
  cairo_t* cr = drawing.get();
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_paint(cr);
  cairo_set_source_rgb(cr, 0, 0, 0);
  cairo_scale(cr, units_per_metre, units_per_metre);
  cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  Sheet(cr, board, paper).draw();
}

void write_pdf(const fs::path& file, std::span<const Board> boards, std::span<const PaperSize> papers) {
  const Surface surface(cairo_pdf_surface_create(file.c_str(), 1, 1));
  for (std::size_t i = 0; i < boards.size(); ++i) {
    cairo_pdf_surface_set_size(surface.get(), papers[i].width * kPointsPerMetre, papers[i].height * kPointsPerMetre);
    draw_sheet(surface.get(), kPointsPerMetre, boards[i], papers[i]);
    cairo_surface_show_page(surface.get());
  }
  cairo_surface_finish(surface.get());
  require_success(cairo_surface_status(surface.get()), file);
}

void write_svg(const fs::path& file, const Board& board, const PaperSize& paper) {
  const Surface surface(
      cairo_svg_surface_create(file.c_str(), paper.width * kPointsPerMetre, paper.height * kPointsPerMetre));
  draw_sheet(surface.get(), kPointsPerMetre, board, paper);
  cairo_surface_finish(surface.get());
  require_success(cairo_surface_status(surface.get()), file);
}

std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24U), static_cast<char>(value >> 16U), static_cast<char>(value >> 8U),
          static_cast<char>(value)};
}

// cairo does not say how large its pixels are: a pHYs chunk after the header does (PNG specification, 11.3.5.3).
std::string with_resolution(const std::string& png, double pixels_per_metre) {
  constexpr std::size_t kHeaderEnd = 8 + 4 + 4 + 13 + 4;
  const auto density = big_endian(static_cast<std::uint32_t>(std::lround(pixels_per_metre)));
  const std::string body = "pHYs" + density + density + '\1';
  const auto checksum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return png.substr(0, kHeaderEnd) + big_endian(9) + body + big_endian(static_cast<std::uint32_t>(checksum)) +
         png.substr(kHeaderEnd);
}

cairo_status_t append_bytes(void* text, const unsigned char* data, unsigned int size) noexcept {
  try {
    static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), size);
    return CAIRO_STATUS_SUCCESS;
  } catch (...) {
    return CAIRO_STATUS_NO_MEMORY;
  }
}

void write_picture(const fs::path& file, const Board& board, const PaperSize& paper, double dpi) {
  constexpr double kMostPixels = 32767;  // a side, cairo's
  const double scale = dpi / 0.0254;
  if (std::max(paper.width, paper.height) * scale > kMostPixels)
    throw InvalidInput(fmt::format("{}: {} at {:g} dpi is too large for a picture; write a .pdf, or less --dpi",
                                   file.string(), paper.name, dpi));
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24,
                                                   static_cast<int>(std::lround(paper.width * scale)),
                                                   static_cast<int>(std::lround(paper.height * scale))));
  draw_sheet(surface.get(), scale, board, paper);
  std::string png;
  require_success(cairo_surface_write_to_png_stream(surface.get(), append_bytes, &png), file);
  replace_file(file, with_resolution(png, scale));
}

void require_fit(std::span<const Board> boards, std::span<const PaperSize> papers) {
  if (boards.empty() || boards.size() != papers.size()) throw InvalidInput("a board needs a paper, each its own");
  for (std::size_t i = 0; i < boards.size(); ++i)
    if (!holds(papers[i], boards[i]))
      throw InvalidInput(
          fmt::format("{} of {:g} x {:g} mm needs a paper of {:g} x {:g} mm or more (margins for rulers); {} has "
                      "{:g} x {:g}",
                      boards[i].name, width_of(boards[i]) * 1e3, height_of(boards[i]) * 1e3,
                      (width_of(boards[i]) + 2 * least_margin(boards[i])) * 1e3,
                      (height_of(boards[i]) + 2 * least_margin(boards[i])) * 1e3, papers[i].name, papers[i].width * 1e3,
                      papers[i].height * 1e3));
}

fs::path file_for(const fs::path& file, std::span<const Board> boards, std::size_t i) {
  if (boards.size() == 1) return file;
  std::string name = boards[i].name;
  std::replace(name.begin(), name.end(), '/', '_');
  return file.parent_path() / fmt::format("{}-{}{}", file.stem().string(), name, file.extension().string());
}

}  // namespace

std::vector<Board> told_apart(const Board& board, int count) {
  if (count > 1 && board.type == BoardType::chessboard)
    throw InvalidInput("several chessboards of one kind cannot be told apart in a picture: use --charuco");
  std::vector<Board> boards(static_cast<std::size_t>(count), board);
  for (int i = 0; i < count && count > 1; ++i) {
    auto& one = boards[static_cast<std::size_t>(i)];
    one.name = fmt::format("board{}", i);
    one.first_marker = board.first_marker + i * static_cast<int>(markers_of(board).size());
  }
  check_boards(boards);
  return boards;
}

std::string board_yaml(std::span<const Board> boards) {
  std::string text = boards.size() == 1 ? "" : "boards:\n";
  const std::string indent = boards.size() == 1 ? "" : "    ";
  for (const auto& board : boards) {
    // A JSON string is a YAML one, whatever is in the name.
    text += fmt::format("{}name: {}\n", boards.size() == 1 ? "" : "  - ", nlohmann::json(board.name).dump());
    if (board.type == BoardType::charuco)
      text += fmt::format(
          "{0}type: charuco\n{0}squares: [{1}, {2}]\n{0}square_mm: {3:.10g}\n{0}marker_mm: {4:.10g}\n"
          "{0}dictionary: {5}\n{0}first_marker: {6}\n",
          indent, board.columns, board.rows, board.square * 1e3, board.marker * 1e3, board.dictionary,
          board.first_marker);
    else
      text += fmt::format("{0}type: chessboard\n{0}inner_corners: [{1}, {2}]\n{0}square_mm: {3:.10g}\n", indent,
                          board.columns - 1, board.rows - 1, board.square * 1e3);
  }
  return text;
}

std::vector<fs::path> write_board_sheets(const fs::path& file, std::span<const Board> boards,
                                         std::span<const PaperSize> papers, double dpi) {
  require_fit(boards, papers);
  const auto ending = file.extension().string();
  if (ending == ".pdf") {
    write_pdf(file, boards, papers);
    return {file};
  }
  if (ending != ".svg" && ending != ".png")
    throw InvalidInput(file.string() + ": boards are written as .pdf, .svg or .png");
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    files.push_back(file_for(file, boards, i));
    if (ending == ".svg")
      write_svg(files.back(), boards[i], papers[i]);
    else
      write_picture(files.back(), boards[i], papers[i], dpi);
  }
  return files;
}

}  // namespace rotunda::capture
