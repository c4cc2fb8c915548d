#pragma once
// The system calls a V4L2 camera is driven by, as one interface: the kernel's, or a test's.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

class V4l2System {
 public:
  virtual ~V4l2System() = default;

  // As open(2) and so on: negative (map: nullptr) and errno where they fail; a signal does not interrupt them.
  virtual int open(const std::string& path) = 0;  // to read and write, without waiting
  virtual void close(int fd) = 0;
  virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
  virtual void* map(int fd, std::size_t bytes, std::int64_t offset) = 0;
  virtual void unmap(void* address, std::size_t bytes) = 0;
  // For something to read. What came, POLLIN | POLLERR | ...; 0 when the time is over.
  virtual int poll(int fd, std::chrono::milliseconds timeout) = 0;

  virtual std::chrono::nanoseconds monotonic_now() = 0;  // CLOCK_MONOTONIC, which drivers stamp frames with
  virtual Timestamp rig_now() = 0;

  virtual std::vector<std::string> nodes() = 0;                // "/dev/video0", ..., by number
  virtual std::string serial_of(const std::string& node) = 0;  // of the USB device behind it; empty if there is none
};

V4l2System& kernel_v4l2();

// An open node; closes it when it goes.
class V4l2Node {
 public:
  V4l2Node(V4l2System& system, const std::string& path) : system_(system), fd_(system.open(path)) {}
  ~V4l2Node() {
    if (fd_ >= 0) system_.close(fd_);
  }
  V4l2Node(const V4l2Node&) = delete;
  V4l2Node& operator=(const V4l2Node&) = delete;

  explicit operator bool() const { return fd_ >= 0; }
  V4l2System& system() const { return system_; }
  int fd() const { return fd_; }

  // Whether the call went well; errno says why not.
  template <class Argument>
  bool ask(unsigned long request, Argument& argument) const {
    return system_.ioctl(fd_, request, &argument) >= 0;
  }

 private:
  V4l2System& system_;
  int fd_;
};

// A CLOCK_MONOTONIC time on the rig's clock. Both clocks are read anew, so that a step of the rig's clock is followed.
Timestamp rig_time_of(V4l2System& system, std::chrono::nanoseconds monotonic);

}  // namespace rotunda::capture
