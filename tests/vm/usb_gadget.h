#pragma once
// A USB device made by a program: the kernel's FunctionFS behind its dummy_hcd, a host controller with a device
// controller wired to it. What libusb sees of it has come through the kernel's USB stack, enumeration and all.
// Needs root, and the modules dummy_hcd and usb_f_fs: a virtual machine. Throws std::system_error.
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>

#include "capture/base/unique_fd.h"

namespace rotunda::vm {

struct UsbGadgetOptions {
  std::string name;  // of the gadget in configfs
  std::uint16_t vendor = 0, product = 0;
  std::string serial;
  std::string controller = "dummy_udc.0";
};

// One vendor-class interface with a bulk endpoint out and one in.
class UsbGadget {
 public:
  explicit UsbGadget(const UsbGadgetOptions& options);  // not plugged in yet
  ~UsbGadget();
  UsbGadget(const UsbGadget&) = delete;
  UsbGadget& operator=(const UsbGadget&) = delete;

  void plug_in();
  void unplug();                             // what was under way ends
  bool enabled() const { return enabled_; }  // a host has configured it

  // A whole transfer, which may wait for the host. False: there is no host (any more).
  bool receive(std::uint8_t* bytes, std::size_t size, std::size_t& received) const;
  bool send(const std::uint8_t* bytes, std::size_t size) const;

 private:
  void make_in_configfs();
  void describe();
  void watch(const std::stop_token& stop);

  UsbGadgetOptions options_;
  std::filesystem::path gadget_, functionfs_;
  capture::UniqueFd control_, out_, in_;
  std::atomic<bool> enabled_{false};
  std::jthread watch_;
};

}  // namespace rotunda::vm
