#pragma once
// A loopback of the test's own: GigE Vision's port 3956 is one for the whole machine, and tests run side by side.
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace rotunda::tests {

// Puts the calling thread, and the threads it starts from now on, into a network with nothing but a loopback. Once a
// process; later calls tell the same. Empty when done, otherwise why it is not permitted: then GTEST_SKIP() << it.
// Without root it must come before the first thread (user namespaces ask for that).
inline std::string enter_private_network() {
  static const std::string refusal = [] {
    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
      return std::string("no private network namespace: ") + std::strerror(errno);
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq request{};
    std::strcpy(request.ifr_name, "lo");
    const bool found = ioctl(fd, SIOCGIFFLAGS, &request) == 0;
    request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP);
    const bool is_up = found && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    const std::string why = is_up ? "" : std::string("the private loopback does not come up: ") + std::strerror(errno);
    close(fd);
    return why;
  }();
  return refusal;
}

}  // namespace rotunda::tests
