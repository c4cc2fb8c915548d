#pragma once
// A display for windows where there is none.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>

extern char** environ;

namespace rotunda::tests {

// An X server without a screen. Throws if it does not start: tests are never passed over for want of a package.
class VirtualScreen {
 public:
  VirtualScreen() {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), 0) != 0) throw std::runtime_error("no pipe to Xvfb");
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
    if (number_.empty()) throw std::runtime_error("Xvfb does not start; it is in scripts/packages.txt (xvfb)");
  }
  ~VirtualScreen() {
    ::kill(server_, SIGTERM);
    ::waitpid(server_, nullptr, 0);
  }
  std::string display() const { return ":" + number_; }

 private:
  pid_t server_ = 0;
  std::string number_;
};

}  // namespace rotunda::tests
