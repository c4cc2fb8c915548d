#pragma once
// Ctrl-C and SIGTERM as a stop token. Make one first thing in main, before any other thread: the signals are blocked
// in every thread made later and waited for in one of its own. A second signal ends the program at once.
#include <stop_token>
#include <thread>

namespace rotunda::capture {

class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::jthread waiter_;
};

}  // namespace rotunda::capture
