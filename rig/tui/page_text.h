#pragma once
// A page as plain text with a style a piece: what a terminal shows, without a terminal. Text is UTF-8; widths are in
// terminal columns (two for a wide ideogram, in a UTF-8 locale).
#include <string>
#include <string_view>
#include <vector>

namespace rotunda::rig {

// Meaning, not colour: a monochrome terminal shows them as bold, dim and reverse.
enum class Style { plain, dim, title, key, good, warn, alarm, recording, selected };

struct Span {
  std::string text;
  Style style = Style::plain;
};
using Line = std::vector<Span>;

struct PageSize {
  int columns = 80;
  int rows = 24;
};

int width_of(std::string_view text);
int width_of(const Line& line);
std::string text_of(const Line& line);

// Exactly `width` columns: cut, or filled with spaces on the right or (for numbers) on the left.
std::string left_in(std::string_view text, int width);
std::string right_in(std::string_view text, int width);
// At most so wide.
Line clipped(const Line& line, int width);
// At spaces where it can; lines after the first are indented by two.
std::vector<std::string> wrapped(std::string_view text, int width);

// One code point as UTF-8, and a text without its last code point.
std::string utf8(char32_t code_point);
void erase_last(std::string& text);

}  // namespace rotunda::rig
