#pragma once
// A trigger box on USB, through libusb: found, opened, claimed; messages out and in. What they say is trigger_box.h's
// matter. One thread may send while another receives.
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "firmware/trigger_box/trigger_box_protocol.h"

struct libusb_context;
struct libusb_device_handle;

namespace rotunda::capture {

using TriggerBoxMessage = std::array<std::uint8_t, TRIGGER_BOX_MESSAGE_BYTES>;

struct CloseUsb {
  void operator()(libusb_context* context) const noexcept;
  void operator()(libusb_device_handle* handle) const noexcept;
};
using UsbContext = std::unique_ptr<libusb_context, CloseUsb>;
using UsbHandle = std::unique_ptr<libusb_device_handle, CloseUsb>;

class TriggerBoxUsb {
 public:
  // The box of this serial number, or the only one if it is empty. Throws DeviceError: none, more than one, no
  // permission, in use, no trigger box's endpoints.
  explicit TriggerBoxUsb(const std::string& serial);

  const std::string& serial() const { return serial_; }

  // What became of a message. Neither whole nor an error: the box was not ready in time.
  struct Moved {
    bool whole = false;
    std::string error;
  };
  Moved send(TriggerBoxMessage message) const;  // within a second
  Moved receive(TriggerBoxMessage& message, std::chrono::milliseconds patience) const;

 private:
  void find_endpoints();
  Moved move(unsigned char endpoint, TriggerBoxMessage& message, std::chrono::milliseconds patience) const;

  UsbContext context_;
  UsbHandle handle_;
  std::string serial_;
  unsigned char out_ = 0, in_ = 0;  // endpoints
};

}  // namespace rotunda::capture
