#include "rig/tui/replay.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace rotunda::rig {
namespace {

bool has_display() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"})
    if (const char* value = std::getenv(name); value && *value) return true;
  return false;
}

// This very program, without the page's terminal and with the signals that the page holds back.
int spawn_player(const std::string& folder, pid_t& child) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::string name = "rotunda", command = "play", take = folder;
  char* const words[] = {name.data(), command.data(), take.data(), nullptr};
  const int error = posix_spawn(&child, "/proc/self/exe", &files, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

}  // namespace

std::string Replay::start(const ListedTake& take) {
  if (child_ > 0) return fmt::format("take {} plays already; close its window first", take_);
  if (!take.reconstructed && !take.at_live_quality)
    return fmt::format("take {} is not reconstructed yet: rotunda recon {}, then rotunda play {}", take.name, take.name,
                       take.name);
  if (!has_display()) return fmt::format("no display here; where there is one: rotunda play {}", take.folder.string());
  if (const int error = spawn_player(take.folder.string(), child_)) {
    child_ = -1;
    return fmt::format("the player does not start ({}): rotunda play {}", std::strerror(error), take.name);
  }
  take_ = take.name;
  return fmt::format("playing {}", take.name);
}

std::optional<std::string> Replay::ended() {
  int status = 0;
  if (child_ <= 0 || waitpid(child_, &status, WNOHANG) != child_) return std::nullopt;
  child_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return std::nullopt;
  return fmt::format("the player ended badly; see why with: rotunda play {}", take_);
}

}  // namespace rotunda::rig
