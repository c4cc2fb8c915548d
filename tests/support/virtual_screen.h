#pragma once
// A display for windows where there is none.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>

extern char** environ;

namespace rotunda::tests {

// An X server without a screen; empty if there is none to start.
class VirtualScreen {
 public:
  VirtualScreen() {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), 0) != 0) return;
    std::string display_fd = std::to_string(pipe[1]);
    std::string name = "Xvfb", option = "-displayfd", screen = "-screen", number = "0", size = "640x480x24";
    char* arguments[] = {name.data(), option.data(), display_fd.data(), screen.data(), number.data(),
                         size.data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int started = ::posix_spawnp(&server_, "Xvfb", &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(pipe[1]);
    char digit = 0;
    while (started == 0 && ::read(pipe[0], &digit, 1) == 1 && digit != '\n') number_ += digit;
    ::close(pipe[0]);
    if (started != 0) server_ = 0;
  }
  ~VirtualScreen() {
    if (server_ <= 0) return;
    ::kill(server_, SIGTERM);
    ::waitpid(server_, nullptr, 0);
  }
  std::string display() const { return number_.empty() ? "" : ":" + number_; }

 private:
  pid_t server_ = 0;
  std::string number_;
};

}  // namespace rotunda::tests
