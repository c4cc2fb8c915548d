#pragma once
// A file that was not there before, written from its beginning. Throws std::system_error naming the file.
#include <cstdint>
#include <filesystem>
#include <span>

#include "capture/base/unique_fd.h"

namespace rotunda::capture {

class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& file);
  void write(std::span<const std::uint8_t> bytes);
  void close();

 private:
  std::filesystem::path file_;
  UniqueFd fd_;
};

// Brings the file to disk and out of memory: read back afterwards, it comes from there.
void bring_to_disk(const std::filesystem::path& file);

}  // namespace rotunda::capture
