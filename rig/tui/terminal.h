#pragma once
// A terminal that a page is drawn on (ncurses), restored whatever ends the program: by the destructor, and by handlers
// for the signals that would kill it (hang-up, quit, abort, bad memory). stderr, where it is the terminal too, is
// silent meanwhile: what libraries log would tear the page. One at a time.
#include <chrono>
#include <memory>
#include <optional>

#include "rig/tui/page_text.h"

namespace rotunda::rig {

class Terminal {
 public:
  // Throws InvalidInput where stdin or stdout is no terminal, or one that is not known (TERM).
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  PageSize size() const;
  void draw(const std::vector<Line>& page);
  // A code point or one of page_keys.h; nothing when none comes in time, or when the size has changed.
  std::optional<char32_t> read_key(std::chrono::milliseconds patience);
  bool gone() const;  // nobody reads or types any more

 private:
  struct Screen;
  std::unique_ptr<Screen> screen_;
};

}  // namespace rotunda::rig
