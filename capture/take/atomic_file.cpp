#include "capture/take/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace rotunda::capture {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

class OpenFile {
 public:
  OpenFile(const std::filesystem::path& file, int flags) : fd_(::open(file.c_str(), flags | O_CLOEXEC, 0644)) {
    if (fd_ < 0) fail(file);
  }
  ~OpenFile() { ::close(fd_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

void write_all(const std::filesystem::path& file, std::string_view text) {
  const OpenFile out(file, O_WRONLY | O_CREAT | O_TRUNC);
  while (!text.empty()) {
    const ssize_t written = ::write(out.fd(), text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(out.fd()) != 0) fail(file);
}

}  // namespace

void sync_folder(const std::filesystem::path& folder) {
  const OpenFile directory(folder, O_RDONLY | O_DIRECTORY);
  if (::fsync(directory.fd()) != 0) fail(folder);
}

void sync_filesystem(const std::filesystem::path& folder) {
  const OpenFile directory(folder, O_RDONLY | O_DIRECTORY);
  if (::syncfs(directory.fd()) != 0) fail(folder);
}

void replace_file(const std::filesystem::path& file, std::string_view text) {
  auto temporary = file;
  temporary += ".new";
  try {
    write_all(temporary, text);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  if (::rename(temporary.c_str(), file.c_str()) != 0) fail(file);
  sync_folder(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."));
}

}  // namespace rotunda::capture
