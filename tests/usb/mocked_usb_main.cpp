// Runs the tests with umockdev between them and the kernel: starts the program anew with its library preloaded. The
// sanitizer's own library, where there is one, must stay in front of it.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

namespace {

constexpr const char* kPreload = "libumockdev-preload.so.0";

std::string sanitizer_library() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const auto path = line.find('/');
    if (path != std::string::npos && line.find("libasan.so", path) != std::string::npos) return line.substr(path) + ":";
  }
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  if (!std::getenv("ROTUNDA_USB_MOCKED")) {
    if (!dlopen(kPreload, RTLD_LAZY)) {
      std::fprintf(stderr, "%s; install the package umockdev (scripts/install-packages does)\n", dlerror());
      return 4;
    }
    setenv("ROTUNDA_USB_MOCKED", "1", 1);
    setenv("LD_PRELOAD", (sanitizer_library() + kPreload).c_str(), 1);
    execv("/proc/self/exe", argv);
    std::perror("cannot start anew under umockdev");
    return 4;
  }
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
