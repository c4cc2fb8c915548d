#pragma once
// Private to recon: files that are whole or not there.
#include <filesystem>
#include <string>
#include <system_error>

namespace rotunda::recon {

// Writes with `write(path)` under another name (of the same extension) and renames; what fails leaves nothing.
template <class Write>
void write_whole(const std::filesystem::path& file, const Write& write) {
  const auto part = file.parent_path() / ("." + file.filename().string());
  try {
    write(part);
    std::filesystem::rename(part, file);
  } catch (...) {
    std::error_code ignored;  // the first failure is the one to tell
    std::filesystem::remove(part, ignored);
    throw;
  }
}
void write_text(const std::filesystem::path& file, const std::string& text);  // throws std::system_error
std::string read_text(const std::filesystem::path& file);                     // empty if there is none

}  // namespace rotunda::recon
