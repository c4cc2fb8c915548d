#pragma once
// Text files of numbers in rows, as other programs write calibrations: words parted by spaces, tabs or commas, comments
// after '#'. Every word knows its place, so that a refusal can name it.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/errors.h"

namespace rotunda::capture {

struct TextWord {
  std::string text;
  int column = 0;  // from 1
};

struct TextRow {
  int line = 0;  // from 1
  std::vector<TextWord> words;
  std::string comment;  // what follows '#', without it; also of rows that hold nothing else
};

// At most 16 MB. Throws ConfigError if the file cannot be read, is a folder, too large, or holds bytes that no text has
// (a NUL: some binary file).
std::string read_text(const std::filesystem::path& file);
// All lines, also empty ones, in order.
std::vector<TextRow> split_rows(std::string_view text);

// A finite number, the whole word.
std::optional<double> number_in(const TextWord& word);

// Numbers of the row from its word `first` on. Throws ConfigError naming the first word that is none.
std::vector<double> numbers_in(const std::filesystem::path& file, const TextRow& row, std::size_t first);

[[noreturn]] void refuse(const std::filesystem::path& file, int line, int column, std::string key, std::string message);

}  // namespace rotunda::capture
