#include "capture/calibration/text_rows.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <system_error>

namespace rotunda::capture {
namespace {

constexpr std::size_t kLargestFile = 16U << 20U;  // bytes
constexpr std::size_t kLongestTold = 40;          // of a word, in messages

TextRow split_row(std::string_view line, int number) {
  TextRow row{.line = number, .words = {}, .comment = {}};
  const auto hash = line.find('#');
  if (hash != std::string_view::npos) row.comment = line.substr(hash + 1);
  line = line.substr(0, hash);
  constexpr std::string_view kBetween = " \t\r,;";
  for (std::size_t at = line.find_first_not_of(kBetween); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBetween, at), line.size());
    row.words.push_back({std::string(line.substr(at, end - at)), static_cast<int>(at) + 1});
    at = line.find_first_not_of(kBetween, end);
  }
  return row;
}

}  // namespace

void refuse(const std::filesystem::path& file, int line, int column, std::string key, std::string message) {
  throw ConfigError(file, {{line, column, std::move(key), std::move(message)}});
}

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) refuse(file, 0, 0, "", "is a folder; a file is wanted here");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, 0, 0, "", "cannot be opened; does the file exist, and may it be read?");
  std::string text(kLargestFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLargestFile) refuse(file, 0, 0, "", "is too large for a calibration (over 16 MB)");
  if (text.find('\0') != std::string::npos) refuse(file, 0, 0, "", "is no text (it holds a byte of zeros)");
  return text;
}

std::vector<TextRow> split_rows(std::string_view text) {
  std::vector<TextRow> rows;
  int number = 1;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    rows.push_back(split_row(text.substr(0, end), number++));
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  }
  return rows;
}

std::optional<double> number_in(const TextWord& word) {
  std::string_view text = word.text;
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> numbers_in(const std::filesystem::path& file, const TextRow& row, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < row.words.size(); ++i) {
    const auto value = number_in(row.words[i]);
    if (!value)
      refuse(file, row.line, row.words[i].column, "",
             fmt::format("expected a finite number, found \"{}\"", row.words[i].text.substr(0, kLongestTold)));
    numbers.push_back(*value);
  }
  return numbers;
}

}  // namespace rotunda::capture
