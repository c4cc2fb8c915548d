#include "capture/sync/trigger_box_usb.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "capture/sync/trigger_box.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::chrono::milliseconds kSendTime{1000};

[[noreturn]] void fail(const std::string& what) {
  throw DeviceError("trigger box", what);
}

UsbContext usb_context() {
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error < 0)
    fail(fmt::format("USB cannot be used: {}", libusb_strerror(error)));
  return UsbContext(context);
}

std::string port_of(libusb_device* device) {
  return fmt::format("{}-{}", libusb_get_bus_number(device), libusb_get_port_number(device));
}

bool is_box(libusb_device* device) {
  libusb_device_descriptor descriptor{};
  return libusb_get_device_descriptor(device, &descriptor) == 0 && descriptor.idVendor == TRIGGER_BOX_VENDOR_ID &&
         descriptor.idProduct == TRIGGER_BOX_PRODUCT_ID;
}

std::string serial_of(libusb_device_handle* handle) {
  libusb_device_descriptor descriptor{};
  std::array<unsigned char, 128> text{};
  if (libusb_get_device_descriptor(libusb_get_device(handle), &descriptor) != 0) return {};
  const int bytes = libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, text.data(), text.size());
  return bytes > 0 ? std::string(text.begin(), text.begin() + bytes) : std::string();
}

struct OpenBox {
  UsbHandle handle;  // empty: could not be opened
  std::string serial, port;
  int error = 0;
};

std::vector<OpenBox> open_boxes(libusb_context* context) {
  libusb_device** devices = nullptr;
  const auto count = libusb_get_device_list(context, &devices);
  std::vector<OpenBox> boxes;
  for (ssize_t i = 0; i < count; ++i) {
    if (!is_box(devices[i])) continue;
    libusb_device_handle* handle = nullptr;
    OpenBox box{.port = port_of(devices[i]), .error = libusb_open(devices[i], &handle)};
    if (box.error == 0) box.handle.reset(handle);
    if (box.handle) box.serial = serial_of(box.handle.get());
    boxes.push_back(std::move(box));
  }
  if (count >= 0) libusb_free_device_list(devices, 1);
  return boxes;
}

OpenBox choose_box(std::vector<OpenBox> boxes, const std::string& serial) {
  if (boxes.empty()) fail("there is none on USB; plug it in");
  std::string seen;
  for (const auto& box : boxes)
    seen += fmt::format("{}{}", seen.empty() ? "" : ", ",
                        box.handle ? box.serial : fmt::format("port {} ({})", box.port, libusb_strerror(box.error)));
  if (!serial.empty())
    boxes.erase(std::remove_if(boxes.begin(), boxes.end(), [&](const auto& box) { return box.serial != serial; }),
                boxes.end());
  if (boxes.empty()) fail(fmt::format("none has the serial number {}; there are: {}", serial, seen));
  if (boxes.size() > 1) fail(fmt::format("there are several ({}); name one with trigger.box", seen));
  if (!boxes.front().handle)
    fail(fmt::format("the one on port {} cannot be opened: {}; install config/udev/70-rotunda.rules",
                     boxes.front().port, libusb_strerror(boxes.front().error)));
  return std::move(boxes.front());
}

}  // namespace

void CloseUsb::operator()(libusb_context* context) const noexcept {
  libusb_exit(context);
}

void CloseUsb::operator()(libusb_device_handle* handle) const noexcept {
  libusb_release_interface(handle, 0);
  libusb_close(handle);
}

std::vector<FoundTriggerBox> find_trigger_boxes() {
  const auto context = usb_context();
  std::vector<FoundTriggerBox> found;
  for (const auto& box : open_boxes(context.get())) found.push_back({box.serial, box.port});
  return found;
}

TriggerBoxUsb::TriggerBoxUsb(const std::string& serial) : context_(usb_context()) {
  auto box = choose_box(open_boxes(context_.get()), serial);
  serial_ = box.serial;
  handle_ = std::move(box.handle);
  if (const int error = libusb_claim_interface(handle_.get(), 0); error < 0)
    fail(fmt::format("{} is in use by another program: {}", serial_, libusb_strerror(error)));
  find_endpoints();
  if (in_ == 0 || out_ == 0)
    fail(fmt::format("{} has no bulk endpoints; its firmware is not a trigger box's", serial_));
}

// A board's USB stack may give them numbers of its own.
void TriggerBoxUsb::find_endpoints() {
  libusb_config_descriptor* raw = nullptr;
  if (libusb_get_active_config_descriptor(libusb_get_device(handle_.get()), &raw) != 0) return;
  const std::unique_ptr<libusb_config_descriptor, decltype(&libusb_free_config_descriptor)> configuration(
      raw, &libusb_free_config_descriptor);
  if (configuration->bNumInterfaces == 0 || configuration->interface[0].num_altsetting == 0) return;
  const auto& interface = configuration->interface[0].altsetting[0];
  for (int i = 0; i < interface.bNumEndpoints; ++i) {
    const auto& endpoint = interface.endpoint[i];
    if ((endpoint.bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
    auto& address = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0 ? in_ : out_;
    if (address == 0) address = endpoint.bEndpointAddress;
  }
}

TriggerBoxUsb::Moved TriggerBoxUsb::send(TriggerBoxMessage message) const {
  return move(out_, message, kSendTime);
}

TriggerBoxUsb::Moved TriggerBoxUsb::receive(TriggerBoxMessage& message, std::chrono::milliseconds patience) const {
  return move(in_, message, patience);
}

TriggerBoxUsb::Moved TriggerBoxUsb::move(unsigned char endpoint, TriggerBoxMessage& message,
                                         std::chrono::milliseconds patience) const {
  int bytes = 0;
  const int error = libusb_bulk_transfer(handle_.get(), endpoint, message.data(), static_cast<int>(message.size()),
                                         &bytes, static_cast<unsigned>(patience.count()));
  const bool failed = error != 0 && error != LIBUSB_ERROR_TIMEOUT && error != LIBUSB_ERROR_INTERRUPTED;
  return {bytes == static_cast<int>(message.size()), failed ? libusb_strerror(error) : ""};
}

}  // namespace rotunda::capture
