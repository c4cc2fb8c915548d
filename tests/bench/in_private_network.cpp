// in_private_network COMMAND...: runs it where there is nothing but a loopback of its own, so that ten cameras can have
// GigE Vision's port each. Without the permission for that it says so and runs it on the machine's own loopback.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tests/support/private_network.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: in_private_network COMMAND [ARGUMENT...]\n");
    return 2;
  }
  const auto refusal = rotunda::tests::enter_private_network();
  if (!refusal.empty()) fmt::print(stderr, "{}; using the machine's own loopback\n", refusal);
  execvp(argv[1], argv + 1);
  fmt::print(stderr, "{}: {}\n", argv[1], std::strerror(errno));
  return 4;
}
