#include "tests/usb/mocked_usb_device.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "capture/base/unique_fd.h"

namespace rotunda::tests {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string hexadecimal(const Bytes& bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

struct DataUnref {
  void operator()(UMockdevIoctlData* data) const noexcept { umockdev_ioctl_data_unref(data); }
};
using Data = std::unique_ptr<UMockdevIoctlData, DataUnref>;

struct Urb {
  Data urb, buffer;
  usbdevfs_urb value{};
};

constexpr unsigned kIn = 0x80;

// What libusb polls in the device's place. The kernel's usbfs can be written to while finished requests wait to be
// fetched; umockdev's plain file always could, and who polled it would keep everybody else from it. A pipe with room
// for one write is as the kernel's.
class PolledNode {
 public:
  explicit PolledNode(const std::string& path) {
    if (unlink(path.c_str()) != 0 || mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no pipe at " + path);
    pipe_ = capture::UniqueFd(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (!pipe_ || fcntl(pipe_.get(), F_SETPIPE_SZ, 4096) < 0) throw std::runtime_error("no use of the pipe " + path);
    set_ready(false);
  }

  void set_ready(bool ready) {
    char byte = 0;
    if (ready == ready_) return;
    if ((ready ? read(pipe_.get(), &byte, 1) : write(pipe_.get(), &byte, 1)) != 1)
      throw std::runtime_error("a pipe that is neither full nor empty");
    ready_ = ready;
  }

 private:
  capture::UniqueFd pipe_;
  bool ready_ = true;
};

}  // namespace

struct MockedUsbDevice::Parts {
  MockedUsbFunctions functions;
  std::string sysfs, node, description;
  UMockdevTestbed* testbed = nullptr;
  UMockdevIoctlBase* handler = nullptr;
  std::recursive_mutex mutex;  // a function may lead to serve()
  std::deque<Urb> waiting_in, done;
  std::optional<PolledNode> polled;
  bool gone = false;

  Parts(const MockedUsbOptions& options, MockedUsbFunctions what)
      : functions(std::move(what)),
        sysfs("/devices/usb1/" + options.port),
        node(fmt::format("/dev/bus/usb/001/{:03}", options.number)),
        description(fmt::format(
            "P: {0}\nN: {1}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DEVNAME={2}\nE: BUSNUM=001\nE: "
            "DEVNUM={3:03}\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum={3}\\n\nA: speed={4}\\n\nA: "
            "serial={5}\\n\nH: descriptors={6}\n",
            sysfs, node.substr(5), node, options.number, options.speed, options.serial,
            hexadecimal(options.descriptors))) {
    testbed = umockdev_testbed_new();
    handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(&Parts::on_ioctl), this);
    plug_in();
  }
  ~Parts() {
    if (!gone) umockdev_testbed_detach_ioctl(testbed, node.c_str(), nullptr);
    g_signal_handlers_disconnect_by_data(handler, this);
    g_object_unref(handler);
    g_object_unref(testbed);
  }

  void plug_in() {
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed, description.c_str(), &error) ||
        !umockdev_testbed_attach_ioctl(testbed, node.c_str(), handler, &error))
      throw std::runtime_error(error->message);
    polled.emplace(root() + node);
    gone = false;
    umockdev_testbed_uevent(testbed, ("/sys" + sysfs).c_str(), "add");
  }

  void unplug() {
    gone = true;
    // As the kernel does it: what was under way ends with ESHUTDOWN and can still be reaped.
    for (auto& urb : std::exchange(waiting_in, {})) finish(std::move(urb), -ESHUTDOWN, {}, 0);
    polled->set_ready(true);  // whoever polls it finds out
    umockdev_testbed_detach_ioctl(testbed, node.c_str(), nullptr);
    umockdev_testbed_uevent(testbed, ("/sys" + sysfs).c_str(), "remove");
    umockdev_testbed_remove_device(testbed, ("/sys" + sysfs).c_str());
  }

  std::string root() const {
    const std::unique_ptr<gchar, decltype(&g_free)> path(umockdev_testbed_get_root_dir(testbed), &g_free);
    return path.get();
  }

  void finish(Urb urb, int status, std::span<const std::uint8_t> bytes, int moved) {
    if (!bytes.empty())
      umockdev_ioctl_data_update(urb.buffer.get(), 0, const_cast<guint8*>(bytes.data()),
                                 static_cast<int>(bytes.size()));
    urb.value.status = status;
    urb.value.actual_length = moved;
    umockdev_ioctl_data_update(urb.urb.get(), 0, reinterpret_cast<guint8*>(&urb.value), sizeof urb.value);
    done.push_back(std::move(urb));
    polled->set_ready(true);
  }

  void serve_waiting() {
    for (auto it = waiting_in.begin(); it != waiting_in.end();) {
      auto bytes = functions.send(it->value.endpoint);
      if (!bytes) {
        ++it;
        continue;
      }
      Urb urb = std::move(*it);
      it = waiting_in.erase(it);
      const auto size = std::min<std::size_t>(bytes->size(), static_cast<std::size_t>(urb.buffer->data_len));
      finish(std::move(urb), size < bytes->size() ? -EOVERFLOW : 0, std::span(*bytes).first(size),
             static_cast<int>(size));
    }
  }

  // Of the requests to the device itself only strings are answered with something; the halt of an endpoint is set and
  // cleared without a word.
  void control(Urb urb) {
    constexpr std::uint8_t get_descriptor = 6, set_feature = 3, string = 3;
    const guint8* setup = urb.buffer->data;
    const int room = urb.buffer->data_len - 8;
    if (setup[1] == set_feature) return finish(std::move(urb), 0, {}, 0);
    const auto text = setup[1] == get_descriptor && setup[3] == string ? functions.string(setup[2]) : Bytes{};
    const int size = std::min<int>(room, static_cast<int>(text.size()));
    if (size > 0) umockdev_ioctl_data_update(urb.buffer.get(), 8, const_cast<guint8*>(text.data()), size);
    finish(std::move(urb), size > 0 ? 0 : -EPIPE, {}, size);
  }

  void submit(Urb urb) {
    if (urb.value.type == USBDEVFS_URB_TYPE_CONTROL) return control(std::move(urb));
    if ((urb.value.endpoint & kIn) != 0) {
      waiting_in.push_back(std::move(urb));
    } else {
      const int size = urb.buffer->data_len;
      functions.receive(urb.value.endpoint, {urb.buffer->data, static_cast<std::size_t>(size)});
      finish(std::move(urb), 0, {}, size);
    }
    serve_waiting();
  }

  void discard(gulong urb_address) {
    const auto it = std::find_if(waiting_in.begin(), waiting_in.end(),
                                 [&](const Urb& urb) { return urb.urb->client_addr == urb_address; });
    if (it == waiting_in.end()) return;
    Urb urb = std::move(*it);
    waiting_in.erase(it);
    finish(std::move(urb), -ENOENT, {}, 0);
  }

  Urb resolve(UMockdevIoctlData* arg) {
    Urb urb;
    urb.urb.reset(umockdev_ioctl_data_resolve(arg, 0, sizeof(usbdevfs_urb), nullptr));
    std::memcpy(&urb.value, urb.urb->data, sizeof urb.value);
    const auto length = static_cast<gsize>(urb.value.buffer_length);
    urb.buffer.reset(umockdev_ioctl_data_resolve(urb.urb.get(), offsetof(usbdevfs_urb, buffer), length, nullptr));
    return urb;
  }

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Parts*>(self)->handle(client);
    return TRUE;
  }

  void handle(UMockdevIoctlClient* client);
};

void MockedUsbDevice::Parts::handle(UMockdevIoctlClient* client) {
  const auto answer = [&](long result, int error = 0) { umockdev_ioctl_client_complete(client, result, error); };
  const auto request = umockdev_ioctl_client_get_request(client);
  UMockdevIoctlData* arg = umockdev_ioctl_client_get_arg(client);
  const std::lock_guard lock(mutex);
  const bool reaps = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
  if (gone && !(reaps && !done.empty())) return answer(-1, ENODEV);
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      Data out(umockdev_ioctl_data_resolve(arg, 0, sizeof(std::uint32_t), nullptr));
      std::uint32_t capabilities = USBDEVFS_CAP_NO_PACKET_SIZE_LIM;  // a transfer is one request, however long
      umockdev_ioctl_data_update(out.get(), 0, reinterpret_cast<guint8*>(&capabilities), sizeof capabilities);
      return answer(0);
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_CLEAR_HALT:
      return answer(0);
    case USBDEVFS_IOCTL:  // of a kernel driver, which there is none
    case USBDEVFS_GETDRIVER:
      return answer(-1, ENODATA);
    case USBDEVFS_SUBMITURB:
      submit(resolve(arg));
      return answer(0);
    case USBDEVFS_REAPURBNDELAY:
    case USBDEVFS_REAPURB: {
      if (done.empty()) return answer(-1, EAGAIN);
      Data out(umockdev_ioctl_data_resolve(arg, 0, sizeof(void*), nullptr));
      umockdev_ioctl_data_set_ptr(out.get(), 0, done.front().urb.get());
      done.pop_front();
      polled->set_ready(gone || !done.empty());
      return answer(0);
    }
    case USBDEVFS_DISCARDURB: {
      const Data urb(umockdev_ioctl_data_resolve(arg, 0, sizeof(usbdevfs_urb), nullptr));
      discard(urb->client_addr);
      return answer(0);
    }
    default:
      return answer(-1, ENOTTY);
  }
}

MockedUsbDevice::MockedUsbDevice(const MockedUsbOptions& options, MockedUsbFunctions functions)
    : parts_(std::make_unique<Parts>(options, std::move(functions))) {}

MockedUsbDevice::~MockedUsbDevice() = default;

void MockedUsbDevice::serve() {
  const std::lock_guard lock(parts_->mutex);
  if (!parts_->gone) parts_->serve_waiting();
}

void MockedUsbDevice::unplug() {
  const std::lock_guard lock(parts_->mutex);
  parts_->unplug();
}

void MockedUsbDevice::plug_in() {
  const std::lock_guard lock(parts_->mutex);
  parts_->plug_in();
}

}  // namespace rotunda::tests
