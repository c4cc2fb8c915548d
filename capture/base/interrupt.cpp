#include "capture/base/interrupt.h"

#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <ctime>

namespace rotunda::capture {
namespace {

sigset_t ending_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

}  // namespace

Interrupt::Interrupt() {
  const sigset_t signals = ending_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread([this, signals](std::stop_token destroyed) {
    pthread_setname_np(pthread_self(), "interrupt");
    const timespec poll{.tv_sec = 0, .tv_nsec = 100'000'000};
    while (!destroyed.stop_requested()) {
      const int signal = sigtimedwait(&signals, nullptr, &poll);
      if (signal < 0) continue;
      if (source_.stop_requested()) _exit(128 + signal);
      source_.request_stop();
    }
  });
}

Interrupt::~Interrupt() = default;

}  // namespace rotunda::capture
