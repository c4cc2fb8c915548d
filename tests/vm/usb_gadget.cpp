#include "tests/vm/usb_gadget.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/usb/functionfs.h>
#include <poll.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>

namespace rotunda::vm {
namespace {

namespace fs = std::filesystem;

const fs::path kConfigFs = "/sys/kernel/config";

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

void write_attribute(const fs::path& file, const std::string& text) {
  const capture::UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (!fd || ::write(fd.get(), text.data(), text.size()) < 0) fail("cannot write " + file.string());
}

capture::UniqueFd open_endpoint(const fs::path& file) {
  capture::UniqueFd fd(::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
  if (!fd) fail("cannot open " + file.string());
  return fd;
}

struct [[gnu::packed]] Interface {
  usb_interface_descriptor interface {};
  usb_endpoint_descriptor_no_audio out{}, in{};
};

usb_endpoint_descriptor_no_audio bulk_endpoint(std::uint8_t address, std::uint16_t packet) {
  usb_endpoint_descriptor_no_audio endpoint{};
  endpoint.bLength = sizeof endpoint;
  endpoint.bDescriptorType = USB_DT_ENDPOINT;
  endpoint.bEndpointAddress = address;
  endpoint.bmAttributes = USB_ENDPOINT_XFER_BULK;
  endpoint.wMaxPacketSize = packet;
  return endpoint;
}

// The kernel gives the endpoints numbers of its own choice.
Interface vendor_interface(std::uint16_t packet) {
  Interface all;
  all.interface.bLength = sizeof all.interface;
  all.interface.bDescriptorType = USB_DT_INTERFACE;
  all.interface.bNumEndpoints = 2;
  all.interface.bInterfaceClass = USB_CLASS_VENDOR_SPEC;
  all.out = bulk_endpoint(1 | USB_DIR_OUT, packet);
  all.in = bulk_endpoint(2 | USB_DIR_IN, packet);
  return all;
}

struct [[gnu::packed]] Descriptors {
  usb_functionfs_descs_head_v2 head{};
  std::uint32_t full_count = 3, high_count = 3;
  Interface full = vendor_interface(64), high = vendor_interface(512);
};

template <class Block>
void write_block(int fd, const Block& block, const char* what) {
  if (::write(fd, &block, sizeof block) != static_cast<ssize_t>(sizeof block)) fail(what);
}

}  // namespace

UsbGadget::UsbGadget(const UsbGadgetOptions& options)
    : options_(options),
      gadget_(kConfigFs / "usb_gadget" / options.name),
      functionfs_("/run/functionfs-" + options.name) {
  make_in_configfs();
  fs::create_directories(functionfs_);
  if (::mount(options_.name.c_str(), functionfs_.c_str(), "functionfs", 0, nullptr) != 0)
    fail("cannot mount functionfs");
  describe();
  out_ = open_endpoint(functionfs_ / "ep1");
  in_ = open_endpoint(functionfs_ / "ep2");
  watch_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
}

UsbGadget::~UsbGadget() {
  std::error_code best_effort;
  try {
    unplug();
  } catch (const std::system_error&) {  // was not plugged in
  }
  watch_ = {};
  in_.reset();
  out_.reset();
  control_.reset();
  ::umount(functionfs_.c_str());
  fs::remove(functionfs_, best_effort);
  fs::remove(gadget_ / "configs/c.1" / ("ffs." + options_.name), best_effort);
  for (const auto* folder : {"configs/c.1/strings/0x409", "configs/c.1"}) ::rmdir((gadget_ / folder).c_str());
  ::rmdir((gadget_ / "functions" / ("ffs." + options_.name)).c_str());
  ::rmdir((gadget_ / "strings/0x409").c_str());
  ::rmdir(gadget_.c_str());
}

void UsbGadget::make_in_configfs() {
  if (!fs::exists(kConfigFs / "usb_gadget") && ::mount("none", kConfigFs.c_str(), "configfs", 0, nullptr) != 0)
    fail("cannot mount configfs");
  const auto function = gadget_ / "functions" / ("ffs." + options_.name);
  fs::create_directory(gadget_);
  fs::create_directory(gadget_ / "strings/0x409");
  fs::create_directory(gadget_ / "configs/c.1");
  fs::create_directory(function);
  write_attribute(gadget_ / "idVendor", fmt::format("{:#06x}", options_.vendor));
  write_attribute(gadget_ / "idProduct", fmt::format("{:#06x}", options_.product));
  write_attribute(gadget_ / "strings/0x409/serialnumber", options_.serial);
  fs::create_directory_symlink(function, gadget_ / "configs/c.1" / function.filename());
}

void UsbGadget::describe() {
  control_ = capture::UniqueFd(::open((functionfs_ / "ep0").c_str(), O_RDWR | O_CLOEXEC));
  if (!control_) fail("cannot open ep0");
  Descriptors descriptors;
  descriptors.head.magic = FUNCTIONFS_DESCRIPTORS_MAGIC_V2;
  descriptors.head.length = sizeof descriptors;
  descriptors.head.flags = FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC;
  write_block(control_.get(), descriptors, "cannot describe the interface");
  usb_functionfs_strings_head strings{};
  strings.magic = FUNCTIONFS_STRINGS_MAGIC;
  strings.length = sizeof strings;
  write_block(control_.get(), strings, "cannot describe the strings");
}

void UsbGadget::plug_in() {
  write_attribute(gadget_ / "UDC", options_.controller);
}

void UsbGadget::unplug() {
  write_attribute(gadget_ / "UDC", "\n");
  enabled_ = false;
}

// What the host does with the device as a whole.
void UsbGadget::watch(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd ready{.fd = control_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, 50) <= 0) continue;
    usb_functionfs_event event{};
    if (::read(control_.get(), &event, sizeof event) != static_cast<ssize_t>(sizeof event)) continue;
    if (event.type == FUNCTIONFS_ENABLE) enabled_ = true;
    if (event.type == FUNCTIONFS_DISABLE || event.type == FUNCTIONFS_UNBIND) enabled_ = false;
    if (event.type != FUNCTIONFS_SETUP) continue;
    // Nothing is asked of the interface itself; an answer in the wrong direction is a stall.
    const bool host_reads = (event.u.setup.bRequestType & USB_DIR_IN) != 0;
    static_cast<void>(host_reads ? ::read(control_.get(), nullptr, 0) : ::write(control_.get(), nullptr, 0));
  }
}

bool UsbGadget::receive(std::uint8_t* bytes, std::size_t size, std::size_t& received) const {
  const ssize_t got = ::read(out_.get(), bytes, size);
  received = got > 0 ? static_cast<std::size_t>(got) : 0;
  return got >= 0;
}

bool UsbGadget::send(const std::uint8_t* bytes, std::size_t size) const {
  return ::write(in_.get(), bytes, size) == static_cast<ssize_t>(size);
}

}  // namespace rotunda::vm
