#include "config/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace rotunda {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kBarWidth = 30;

bool can_redraw() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) && terminal && std::string(terminal) != "dumb";
}

std::string time_left(std::chrono::duration<double> spent, std::size_t done, std::size_t total) {
  if (done == 0 || done >= total) return "";
  const auto left = spent.count() * static_cast<double>(total - done) / static_cast<double>(done);
  return fmt::format(", {} s left", static_cast<long>(left + 0.5));
}

}  // namespace

Progress::Progress(std::string what)
    : what_(std::move(what)), terminal_(can_redraw()), begun_(std::chrono::steady_clock::now()), told_(begun_) {}

Progress::~Progress() {
  if (drawn_) std::fputc('\n', stderr);
}

void Progress::update(std::size_t done, std::size_t total, const std::string& note) {
  const auto now = std::chrono::steady_clock::now();
  const bool last = done >= total;
  if (now - told_ < (terminal_ ? 100ms : 5s) && !last) return;
  told_ = now;
  if (terminal_) return draw_bar(done, total, note);
  fmt::print(stderr, "{}: {} of {}{}{}\n", what_, done, total, time_left(now - begun_, done, total),
             note.empty() ? "" : ", " + note);
}

void Progress::draw_bar(std::size_t done, std::size_t total, const std::string& note) {
  const std::size_t full = total ? kBarWidth * std::min(done, total) / total : 0;
  fmt::print(stderr, "\r\x1b[K{} [{}{}] {}/{}{}{}", what_, std::string(full, '#'), std::string(kBarWidth - full, '.'),
             done, total, time_left(told_ - begun_, done, total), note.empty() ? "" : ", " + note);
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace rotunda
