#pragma once
// A device on a mocked USB port: umockdev between libusb and the kernel, this behind its usbdevfs. Bulk transfers of
// any size and string descriptors; no isochronous ones. Needs a process that runs under umockdev (mocked_usb_main.cpp).
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace rotunda::tests {

struct MockedUsbOptions {
  std::string port = "1-4";  // bus and port
  unsigned number = 2;       // of the device on its bus
  std::string serial;
  std::string speed = "12";               // megabits a second, as sysfs has it
  std::vector<std::uint8_t> descriptors;  // of the device, then its configuration
};

// What the device does. Called one at a time, on umockdev's thread or that of serve().
struct MockedUsbFunctions {
  std::function<std::vector<std::uint8_t>(unsigned number)> string;                 // empty: a stall
  std::function<void(unsigned endpoint, std::span<const std::uint8_t>)> receive;    // an OUT transfer
  std::function<std::optional<std::vector<std::uint8_t>>(unsigned endpoint)> send;  // nothing: not yet
};

class MockedUsbDevice {
 public:
  MockedUsbDevice(const MockedUsbOptions& options, MockedUsbFunctions functions);
  ~MockedUsbDevice();
  MockedUsbDevice(const MockedUsbDevice&) = delete;
  MockedUsbDevice& operator=(const MockedUsbDevice&) = delete;

  void serve();    // there may be something to send; the caller holds no lock that the functions take
  void unplug();   // transfers fail from now on, and it is gone from the bus
  void plug_in();  // again; from the start it is

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rotunda::tests
