#include "capture/take/archive_manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>

#include "capture/take/atomic_file.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigits = 64;
constexpr std::string_view kBetween = "  ";

bool is_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

// A path that stays where it is put, however it is written.
bool stays_inside(const fs::path& path) {
  return !path.empty() && path.is_relative() && path == path.lexically_normal() && *path.begin() != "..";
}

bool is_line(std::string_view line) {
  return line.size() > kDigits + kBetween.size() && std::all_of(line.begin(), line.begin() + kDigits, is_digit) &&
         line.substr(kDigits, kBetween.size()) == kBetween && stays_inside(line.substr(kDigits + kBetween.size()));
}

}  // namespace

bool is_archive(const fs::path& folder) {
  return fs::exists(archive_sums(folder));
}

fs::path recorded_sums(const fs::path& folder) {
  return folder / "archive" / "recorded.sha256";
}
fs::path archive_sums(const fs::path& folder) {
  return folder / "archive" / "SHA256SUMS";
}

FileSums read_sums(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  FileSums sums;
  std::uint64_t offset = 0;
  for (std::string line; std::getline(stream, line); offset += line.size() + 1) {
    if (stream.eof() || !is_line(line))
      throw CorruptData(file, offset, "this line is no SHA-256 and file, or cut short");
    sums[line.substr(kDigits + kBetween.size())] = line.substr(0, kDigits);
  }
  if (sums.empty()) throw CorruptData(file, 0, "is empty");
  return sums;
}

void write_sums(const fs::path& file, const FileSums& sums) {
  std::string text;
  for (const auto& [path, sum] : sums) text += fmt::format("{}{}{}\n", sum, kBetween, path);
  replace_file(file, text);
}

fs::path rest_file(const fs::path& folder, const CameraId& camera) {
  return folder / "archive" / (camera + ".rest");
}

}  // namespace rotunda::capture
