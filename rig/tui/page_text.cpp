#include "rig/tui/page_text.h"

#include <cwchar>

namespace rotunda::rig {
namespace {

bool continues(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

// The bytes of the first code point.
std::size_t length_of_first(std::string_view text) {
  std::size_t length = 1;
  while (length < text.size() && continues(text[length])) ++length;
  return length;
}

char32_t code_point(std::string_view bytes) {
  const auto first = static_cast<unsigned char>(bytes[0]);
  if (bytes.size() == 1) return first;
  char32_t value = first & (0xFFU >> (bytes.size() + 1));
  for (const char byte : bytes.substr(1)) value = (value << 6) | (static_cast<unsigned char>(byte) & 0x3FU);
  return value;
}

int width_of_first(std::string_view bytes) {
  if (bytes.size() == 1) return 1;
  const int width = wcwidth(static_cast<wchar_t>(code_point(bytes)));
  return width < 0 ? 1 : width;
}

// As many whole code points as fit.
std::string_view fitting(std::string_view text, int width) {
  std::size_t end = 0;
  int used = 0;
  while (end < text.size()) {
    const auto bytes = text.substr(end, length_of_first(text.substr(end)));
    if (used + width_of_first(bytes) > width) break;
    used += width_of_first(bytes);
    end += bytes.size();
  }
  return text.substr(0, end);
}

}  // namespace

int width_of(std::string_view text) {
  int width = 0;
  while (!text.empty()) {
    const auto bytes = text.substr(0, length_of_first(text));
    width += width_of_first(bytes);
    text.remove_prefix(bytes.size());
  }
  return width;
}

int width_of(const Line& line) {
  int width = 0;
  for (const auto& span : line) width += width_of(span.text);
  return width;
}

std::string text_of(const Line& line) {
  std::string text;
  for (const auto& span : line) text += span.text;
  return text;
}

std::string left_in(std::string_view text, int width) {
  std::string cell(fitting(text, width));
  return cell.append(static_cast<std::size_t>(width - width_of(cell)), ' ');
}

std::string right_in(std::string_view text, int width) {
  const auto fits = fitting(text, width);
  return std::string(static_cast<std::size_t>(width - width_of(fits)), ' ').append(fits);
}

Line clipped(const Line& line, int width) {
  Line result;
  for (const auto& span : line) {
    if (width <= 0) break;
    result.push_back({std::string(fitting(span.text, width)), span.style});
    width -= width_of(result.back().text);
  }
  return result;
}

std::vector<std::string> wrapped(std::string_view text, int width) {
  std::vector<std::string> lines;
  std::string indent;
  while (!text.empty()) {
    auto part = fitting(text, width - static_cast<int>(indent.size()));
    if (part.empty()) break;  // no room at all
    if (part.size() < text.size() && text[part.size()] != ' ')
      if (const auto space = part.rfind(' '); space != part.npos && space > 0) part = part.substr(0, space);
    lines.push_back(indent + std::string(part));
    text.remove_prefix(part.size());
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    indent = "  ";
  }
  return lines;
}

std::string utf8(char32_t code) {
  const auto tail = [code](int shift) { return static_cast<char>(0x80U | ((code >> shift) & 0x3FU)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0U | (code >> 6)), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xE0U | (code >> 12)), tail(6), tail(0)};
  return {static_cast<char>(0xF0U | (code >> 18)), tail(12), tail(6), tail(0)};
}

void erase_last(std::string& text) {
  while (!text.empty() && continues(text.back())) text.pop_back();
  if (!text.empty()) text.pop_back();
}

}  // namespace rotunda::rig
