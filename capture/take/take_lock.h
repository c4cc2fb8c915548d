#pragma once
// Marks a take's folder as being written; held by the process, so it ends with it however it ends.
#include <filesystem>

namespace rotunda::capture {

class TakeLock {
 public:
  // Throws InvalidInput if another writer holds the folder, std::system_error if it cannot be opened.
  explicit TakeLock(const std::filesystem::path& folder);
  ~TakeLock();
  TakeLock(const TakeLock&) = delete;
  TakeLock& operator=(const TakeLock&) = delete;

 private:
  int fd_;
};

}  // namespace rotunda::capture
