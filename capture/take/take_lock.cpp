#include "capture/take/take_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "config/errors.h"

namespace rotunda::capture {

TakeLock::TakeLock(const std::filesystem::path& folder)
    : fd_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "cannot open " + folder.string());
  if (::flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
  ::close(fd_);
  throw InvalidInput(folder.string() + " is being recorded; stop the take first");
}

TakeLock::~TakeLock() {
  ::close(fd_);
}

}  // namespace rotunda::capture
