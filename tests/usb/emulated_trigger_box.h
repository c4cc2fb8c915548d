#pragma once
// A trigger box on a mocked USB port (umockdev): the firmware's own state machine behind usbdevfs, on a clock of its
// own. Needs a process that runs under umockdev (mocked_usb_main.cpp).
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace rotunda::tests {

struct EmulatedTriggerBoxOptions {
  std::string serial = "TB0001";
  double fast_ppm = 0.0;  // of its crystal
  unsigned lines = 2;
};

class EmulatedTriggerBox {
 public:
  using OnEdge = std::function<void(unsigned line, bool high)>;  // on the box's timer thread, when it happens

  explicit EmulatedTriggerBox(const EmulatedTriggerBoxOptions& options = {}, OnEdge on_edge = {});
  ~EmulatedTriggerBox();

  void unplug();              // transfers fail with ENODEV from now on, and it is gone from the bus
  void stop_answering();      // swallows commands
  std::uint64_t now() const;  // its clock, ns
  std::uint64_t pulses() const;
  int commands() const;  // received

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rotunda::tests
