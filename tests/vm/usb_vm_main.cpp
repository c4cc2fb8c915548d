// The tests of USB devices; or, with --host-that-dies, the host of one of them: a program that starts a pulse train and
// ends as kill -9 would end it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <string_view>

#include "capture/sync/trigger_box.h"

namespace {

[[noreturn]] void start_a_train_and_die() {
  using namespace std::chrono_literals;
  rotunda::capture::TriggerBox box("TB0042");
  box.set({.period = 40ms});
  box.start(rotunda::capture::RigClock::now() + 2s);
  ::_exit(0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--host-that-dies") start_a_train_and_die();
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
