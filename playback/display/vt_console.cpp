#include "playback/display/vt_console.h"

#include <fcntl.h>
#include <linux/kd.h>
#include <linux/vt.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

namespace rotunda::playback {
namespace {

struct ConsoleState {
  int mode = KD_TEXT;
  int keyboard = K_UNICODE;
};

bool read_state(int console, ConsoleState& state) {
  return ::ioctl(console, KDGETMODE, &state.mode) == 0 && ::ioctl(console, KDGKBMODE, &state.keyboard) == 0;
}

// The one this program was started on, or for root the one that is seen.
capture::UniqueFd open_console(ConsoleState& state) {
  constexpr int kFlags = O_RDWR | O_NOCTTY | O_CLOEXEC;
  capture::UniqueFd own(::open("/dev/tty", kFlags));
  if (own && read_state(own.get(), state)) return own;
  const capture::UniqueFd seen(::open("/dev/tty0", kFlags));
  vt_stat consoles{};
  if (!seen || ::ioctl(seen.get(), VT_GETSTATE, &consoles) != 0) return {};
  capture::UniqueFd named(::open(("/dev/tty" + std::to_string(consoles.v_active)).c_str(), kFlags));
  if (named && read_state(named.get(), state)) return named;
  return {};
}

// In the keeper, which shares nothing with the program but these two: only plain system calls.
[[noreturn]] void keep(int console, int alive, const ConsoleState& before) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::prctl(PR_SET_NAME, "console keeper");
  ::dup2(console, 0);
  ::dup2(alive, 1);
  ::close_range(2, ~0U, 0);
  char never = 0;
  while (::read(1, &never, 1) > 0) {
  }
  ::ioctl(0, KDSKBMODE, before.keyboard);
  ::ioctl(0, KDSETMODE, before.mode);
  ::_exit(0);
}

}  // namespace

VtConsole::VtConsole(bool with_keyboard) {
  ConsoleState before;
  const auto console = open_console(before);
  int ends[2];
  if (!console || ::pipe2(ends, O_CLOEXEC) != 0) return;
  const capture::UniqueFd theirs(ends[0]);
  alive_.reset(ends[1]);
  if (::ioctl(console.get(), KDSETMODE, KD_GRAPHICS) != 0) return;
  keeper_ = ::fork();
  if (keeper_ == 0) keep(console.get(), theirs.get(), before);
  if (keeper_ < 0)
    ::ioctl(console.get(), KDSETMODE, before.mode);
  else if (with_keyboard)
    ::ioctl(console.get(), KDSKBMODE, K_OFF);
}

VtConsole::~VtConsole() {
  alive_.reset();
  if (keeper_ > 0) ::waitpid(keeper_, nullptr, 0);
}

}  // namespace rotunda::playback
