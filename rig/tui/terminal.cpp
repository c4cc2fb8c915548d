#include "rig/tui/terminal.h"

#define NCURSES_WIDECHAR 1
#include <curses.h>
#include <fcntl.h>
#include <poll.h>
#include <term.h>
#include <termios.h>
#include <unistd.h>
#undef lines  // curses' macros would rename ours
#undef columns

#include <array>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "capture/base/unique_fd.h"
#include "config/errors.h"
#include "rig/tui/page_keys.h"

namespace rotunda::rig {
namespace {

constexpr std::array kFatal{SIGHUP, SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};

// All that a signal handler may touch: prepared before the handlers are set.
struct Rescue {
  termios before{};
  std::array<char, 128> bytes{};
  std::size_t length = 0;
};
Rescue rescue;

extern "C" void restore_and_die(int signal) {
  tcsetattr(STDOUT_FILENO, TCSANOW, &rescue.before);
  [[maybe_unused]] const auto written = write(STDOUT_FILENO, rescue.bytes.data(), rescue.length);
  raise(signal);  // the handler is reset: this ends the program as the signal would have
}

void remember(const char* capability) {
  const char* text = tigetstr(capability);
  if (!text || text == reinterpret_cast<const char*>(-1)) return;
  for (; *text && rescue.length < rescue.bytes.size(); ++text) rescue.bytes[rescue.length++] = *text;
}

void prepare_rescue() {
  rescue.length = 0;
  for (const char* capability : {"sgr0", "rmkx", "cnorm", "rmcup"}) remember(capability);
}

short pair_of(Style style) {
  return static_cast<short>(static_cast<int>(style) + 1);
}

void make_colours() {
  start_color();
  const short background = use_default_colors() == OK ? -1 : COLOR_BLACK;  // -1: the terminal's own
  init_pair(pair_of(Style::good), COLOR_GREEN, background);
  init_pair(pair_of(Style::warn), COLOR_YELLOW, background);
  init_pair(pair_of(Style::alarm), COLOR_WHITE, COLOR_RED);
  init_pair(pair_of(Style::recording), COLOR_WHITE, COLOR_RED);
  init_pair(pair_of(Style::key), COLOR_CYAN, background);
}

attr_t attributes_of(Style style, bool colours) {
  const auto paint = [&](attr_t without) { return colours ? COLOR_PAIR(pair_of(style)) : without; };
  switch (style) {
    case Style::plain:
      return A_NORMAL;
    case Style::dim:
      return A_DIM;
    case Style::title:
      return A_BOLD;
    case Style::key:
      return A_BOLD | paint(A_NORMAL);
    case Style::good:
      return paint(A_NORMAL);
    case Style::warn:
      return A_BOLD | paint(A_NORMAL);
    case Style::alarm:
      return A_BOLD | paint(A_REVERSE);
    case Style::recording:
      return A_BOLD | paint(A_REVERSE);
    case Style::selected:
      return A_REVERSE;
  }
  return A_NORMAL;
}

[[noreturn]] void refuse(const std::string& why) {
  throw InvalidInput(why + "; rotunda status tells the same once, in words or as --json");
}

// stderr goes nowhere while it would go to the page.
class QuietErrors {
 public:
  QuietErrors() {
    if (!isatty(STDERR_FILENO)) return;
    before_ = capture::UniqueFd(fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3));
    const capture::UniqueFd nowhere(open("/dev/null", O_WRONLY | O_CLOEXEC));
    if (before_ && nowhere) dup2(nowhere.get(), STDERR_FILENO);
  }
  ~QuietErrors() {
    if (before_) dup2(before_.get(), STDERR_FILENO);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  capture::UniqueFd before_;
};

char32_t own_key(wint_t key) {
  switch (key) {
    case KEY_UP:
      return kKeyUp;
    case KEY_DOWN:
      return kKeyDown;
    case KEY_ENTER:
      return kKeyEnter;
    case KEY_BACKSPACE:
      return kKeyBackspace;
    default:
      return 0;
  }
}

}  // namespace

struct Terminal::Screen {
  QuietErrors quiet;
  SCREEN* curses = nullptr;
  bool colours = false;
  std::array<struct sigaction, kFatal.size()> before{};

  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;
};

Terminal::Screen::Screen() {
  std::setlocale(LC_CTYPE, "");
  tcgetattr(STDOUT_FILENO, &rescue.before);
  ::setenv("ESCDELAY", "25", 0);
  curses = newterm(nullptr, stdout, stdin);
  if (!curses) refuse("rotunda tui does not know this terminal (TERM)");
  prepare_rescue();
  for (std::size_t i = 0; i < kFatal.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = restore_and_die;
    action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_NODEFER;
    sigaction(kFatal[i], &action, &before[i]);
  }
  raw();  // Ctrl-C is a key: quitting must say that it stops no recording
  noecho();
  nonl();
  keypad(stdscr, TRUE);
  curs_set(0);
  colours = has_colors();
  if (colours) make_colours();
}

Terminal::Screen::~Screen() {
  endwin();
  for (std::size_t i = 0; i < kFatal.size(); ++i) sigaction(kFatal[i], &before[i], nullptr);
  delscreen(curses);
}

Terminal::Terminal() {
  if (!isatty(STDIN_FILENO) || !isatty(STDOUT_FILENO)) refuse("rotunda tui needs a terminal to draw on");
  screen_ = std::make_unique<Screen>();
}

Terminal::~Terminal() = default;

PageSize Terminal::size() const {
  return {.columns = getmaxx(stdscr), .rows = getmaxy(stdscr)};
}

void Terminal::draw(const std::vector<Line>& page) {
  werase(stdscr);
  for (std::size_t row = 0; row < page.size(); ++row) {
    wmove(stdscr, static_cast<int>(row), 0);
    for (const auto& span : page[row]) {
      wattrset(stdscr, attributes_of(span.style, screen_->colours));
      waddstr(stdscr, span.text.c_str());
    }
  }
  wattrset(stdscr, A_NORMAL);
  wrefresh(stdscr);
}

std::optional<char32_t> Terminal::read_key(std::chrono::milliseconds patience) {
  wtimeout(stdscr, static_cast<int>(patience.count()));
  wint_t key = 0;
  const int kind = wget_wch(stdscr, &key);
  if (kind == OK) return key == '\r' ? kKeyEnter : static_cast<char32_t>(key);
  if (kind == KEY_CODE_YES && own_key(key) != 0) return own_key(key);
  return std::nullopt;
}

bool Terminal::gone() const {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return ::poll(&input, 1, 0) > 0 && (input.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

}  // namespace rotunda::rig
