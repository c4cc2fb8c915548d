#pragma once
// A file open for reading at any place; several threads may read at once. Throws std::system_error naming the file.
#include <cstdint>
#include <filesystem>
#include <span>

#include "capture/base/unique_fd.h"

namespace rotunda::capture {

class ReadableFile {
 public:
  explicit ReadableFile(const std::filesystem::path& file);

  std::int64_t size() const;  // bytes
  // How many bytes there were: fewer than asked for at the file's end.
  std::size_t read(std::int64_t offset, std::span<std::uint8_t> bytes) const;

 private:
  std::filesystem::path file_;
  UniqueFd fd_;
};

}  // namespace rotunda::capture
