#include "tests/usb/emulated_trigger_box.h"

#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/trigger_box/trigger_box.h"

namespace rotunda::test {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr const char* kNode = "/dev/bus/usb/001/002";

void put16(Bytes& to, unsigned value) {
  to.push_back(static_cast<std::uint8_t>(value & 0xFF));
  to.push_back(static_cast<std::uint8_t>(value >> 8));
}

// Device, configuration, interface and two bulk endpoints (USB 2.0, 9.6).
Bytes descriptors() {
  Bytes d{18, 1, 0, 2, 0, 0, 0, 64};
  put16(d, TRIGGER_BOX_VENDOR_ID);
  put16(d, TRIGGER_BOX_PRODUCT_ID);
  put16(d, 0x0100);
  d.insert(d.end(), {0, 0, 1, 1});  // serial number is string 1; one configuration
  d.insert(d.end(), {9, 2, 32, 0, 1, 1, 0, 0x80, 50});
  d.insert(d.end(), {9, 4, 0, 0, 2, 0xFF, 0, 0, 0});
  d.insert(d.end(), {7, 5, TRIGGER_BOX_ENDPOINT_OUT, 2, 64, 0, 0});
  d.insert(d.end(), {7, 5, TRIGGER_BOX_ENDPOINT_IN, 2, 64, 0, 0});
  return d;
}

std::string hexadecimal(const Bytes& bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

// A string descriptor in UTF-16; number 0 lists the languages.
Bytes string_descriptor(unsigned number, const std::string& serial) {
  Bytes text{0, 3};
  if (number == 0) put16(text, 0x0409);
  for (std::size_t i = 0; number != 0 && i < serial.size(); ++i) put16(text, static_cast<unsigned char>(serial[i]));
  text[0] = static_cast<std::uint8_t>(text.size());
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

}  // namespace

struct EmulatedTriggerBox::Parts {
  EmulatedTriggerBoxOptions options;
  OnEdge on_edge;
  UMockdevTestbed* testbed = nullptr;
  UMockdevIoctlBase* handler = nullptr;
  std::string sysfs;
  mutable std::mutex mutex;
  std::condition_variable_any changed;
  trigger_box box{};
  std::deque<std::pair<unsigned, bool>> edges;  // of the advance under way
  std::deque<Urb> waiting_in, done;
  std::deque<std::array<std::uint8_t, TRIGGER_BOX_MESSAGE_BYTES>> replies;
  bool gone = false, deaf = false;
  int commands = 0;
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  std::jthread timer;

  explicit Parts(const EmulatedTriggerBoxOptions& chosen, OnEdge on_edge_)
      : options(chosen), on_edge(std::move(on_edge_)) {
    trigger_box_init(&box, options.lines, 8000, &Parts::set_line, this);
    edges.clear();
    testbed = umockdev_testbed_new();
    const std::string device = fmt::format(
        "P: /devices/usb1/1-4\nN: bus/usb/001/002\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: "
        "DEVNAME=/dev/bus/usb/001/002\nE: BUSNUM=001\nE: "
        "DEVNUM=002\n"
        "A: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum=2\\n\nA: speed=12\\n\nA: serial={}\\n\nH: "
        "descriptors={}\n",
        options.serial, hexadecimal(descriptors()));
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed, device.c_str(), &error)) throw std::runtime_error(error->message);
    handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(&Parts::on_ioctl), this);
    if (!umockdev_testbed_attach_ioctl(testbed, kNode, handler, &error)) throw std::runtime_error(error->message);
    timer = std::jthread([this](std::stop_token stop) { run_timer(std::move(stop)); });
  }
  ~Parts() {
    timer.request_stop();
    changed.notify_all();
    timer.join();
    umockdev_testbed_detach_ioctl(testbed, kNode, nullptr);
    g_signal_handlers_disconnect_by_data(handler, this);
    g_object_unref(handler);
    g_object_unref(testbed);
  }

  static void set_line(void* self, unsigned line, bool high, std::uint64_t) {
    static_cast<Parts*>(self)->edges.emplace_back(line, high);
  }

  std::uint64_t now() const {
    const auto since = std::chrono::steady_clock::now() - begun;
    const auto ns = static_cast<double>(std::chrono::nanoseconds(since).count());
    return 1'000'000'000 + static_cast<std::uint64_t>(ns * (1.0 + options.fast_ppm * 1e-6));
  }

  // The hardware timer's interrupt.
  void run_timer(std::stop_token stop) {
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      std::uint64_t next = 0;
      const bool pulsing = !gone && trigger_box_next_edge(&box, &next);
      const std::uint64_t time = now();
      if (!pulsing || next > time) {
        const auto wait = pulsing ? std::chrono::nanoseconds(std::min<std::uint64_t>(next - time, 20'000'000))
                                  : std::chrono::nanoseconds(20'000'000);
        changed.wait_for(lock, stop, wait, [] { return false; });
        continue;
      }
      trigger_box_advance(&box, time);
      serve_waiting();
      const auto happened = std::exchange(edges, {});
      lock.unlock();
      for (const auto& [line, high] : happened)
        if (on_edge) on_edge(line, high);
      lock.lock();
    }
  }

  void finish(Urb urb, int status, const std::uint8_t* bytes, int size) {
    if (bytes && size) umockdev_ioctl_data_update(urb.buffer.get(), 0, const_cast<guint8*>(bytes), size);
    urb.value.status = status;
    urb.value.actual_length = size;
    umockdev_ioctl_data_update(urb.urb.get(), 0, reinterpret_cast<guint8*>(&urb.value), sizeof urb.value);
    done.push_back(std::move(urb));
  }

  // Replies before events, as a full IN endpoint would have sent them.
  void serve_waiting() {
    std::array<std::uint8_t, TRIGGER_BOX_MESSAGE_BYTES> message{};
    while (!waiting_in.empty()) {
      if (!replies.empty()) {
        message = replies.front();
        replies.pop_front();
      } else if (!trigger_box_pop_event(&box, message.data())) {
        return;
      }
      Urb urb = std::move(waiting_in.front());
      waiting_in.pop_front();
      finish(std::move(urb), 0, message.data(), static_cast<int>(message.size()));
    }
  }

  void control(Urb urb) {  // only GET_DESCRIPTOR of strings is asked of the device itself
    const guint8* setup = urb.buffer->data;
    const gint size = urb.buffer->data_len;
    const bool is_string = size >= 8 && setup[1] == 6 && setup[3] == 3;
    const auto text = is_string ? string_descriptor(setup[2], options.serial) : Bytes{};
    const int room = size - 8, length = std::min<int>(room, static_cast<int>(text.size()));
    if (is_string) umockdev_ioctl_data_update(urb.buffer.get(), 8, const_cast<guint8*>(text.data()), length);
    finish(std::move(urb), is_string ? 0 : -EPIPE, nullptr, is_string ? length : 0);
  }

  void submit(Urb urb) {
    if (urb.value.type == USBDEVFS_URB_TYPE_CONTROL) return control(std::move(urb));
    if (urb.value.endpoint & 0x80) {
      waiting_in.push_back(std::move(urb));
      return serve_waiting();
    }
    ++commands;
    if (!deaf) {
      auto& reply = replies.emplace_back();
      trigger_box_command(&box, urb.buffer->data, static_cast<std::size_t>(urb.buffer->data_len), now(), reply.data());
    }
    const int size = urb.buffer->data_len;
    finish(std::move(urb), 0, nullptr, size);
    serve_waiting();
    changed.notify_all();
  }

  void discard(gulong urb_address) {
    for (auto it = waiting_in.begin(); it != waiting_in.end(); ++it) {
      if (it->urb->client_addr != urb_address) continue;
      Urb urb = std::move(*it);
      waiting_in.erase(it);
      return finish(std::move(urb), -ENOENT, nullptr, 0);
    }
  }

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Parts*>(self)->handle(client);
    return TRUE;
  }

  void handle(UMockdevIoctlClient* client);
};

void EmulatedTriggerBox::Parts::handle(UMockdevIoctlClient* client) {
  const auto answer = [&](long result, int error = 0) { umockdev_ioctl_client_complete(client, result, error); };
  const auto request = umockdev_ioctl_client_get_request(client);
  UMockdevIoctlData* arg = umockdev_ioctl_client_get_arg(client);
  std::unique_lock lock(mutex);
  const bool reaps = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
  if (gone && !(reaps && !done.empty())) return answer(-1, ENODEV);
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      Data out(umockdev_ioctl_data_resolve(arg, 0, sizeof(std::uint32_t), nullptr));
      std::uint32_t capabilities = 0;
      umockdev_ioctl_data_update(out.get(), 0, reinterpret_cast<guint8*>(&capabilities), sizeof capabilities);
      return answer(0);
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_CLEAR_HALT:
      return answer(0);
    case USBDEVFS_SUBMITURB: {
      Urb urb;
      urb.urb.reset(umockdev_ioctl_data_resolve(arg, 0, sizeof(usbdevfs_urb), nullptr));
      std::memcpy(&urb.value, urb.urb->data, sizeof urb.value);
      urb.buffer.reset(umockdev_ioctl_data_resolve(urb.urb.get(), offsetof(usbdevfs_urb, buffer),
                                                   static_cast<gsize>(urb.value.buffer_length), nullptr));
      submit(std::move(urb));
      return answer(0);
    }
    case USBDEVFS_REAPURBNDELAY:
    case USBDEVFS_REAPURB: {
      if (done.empty()) {
        lock.unlock();
        std::this_thread::sleep_for(std::chrono::microseconds(200));  // the mocked file is always ready
        return answer(-1, EAGAIN);
      }
      Data out(umockdev_ioctl_data_resolve(arg, 0, sizeof(void*), nullptr));
      umockdev_ioctl_data_set_ptr(out.get(), 0, done.front().urb.get());
      done.pop_front();
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

EmulatedTriggerBox::EmulatedTriggerBox(const EmulatedTriggerBoxOptions& options, OnEdge on_edge)
    : parts_(std::make_unique<Parts>(options, std::move(on_edge))) {}

EmulatedTriggerBox::~EmulatedTriggerBox() = default;

void EmulatedTriggerBox::unplug() {
  const std::lock_guard lock(parts_->mutex);
  parts_->gone = true;
  // As the kernel does it: what was under way ends with ESHUTDOWN and can still be reaped.
  for (auto& urb : std::exchange(parts_->waiting_in, {})) parts_->finish(std::move(urb), -ESHUTDOWN, nullptr, 0);
  trigger_box_unplugged(&parts_->box);
  umockdev_testbed_remove_device(parts_->testbed, "/sys/devices/usb1/1-4");
}

void EmulatedTriggerBox::stop_answering() {
  const std::lock_guard lock(parts_->mutex);
  parts_->deaf = true;
}

std::uint64_t EmulatedTriggerBox::now() const {
  return parts_->now();
}

std::uint64_t EmulatedTriggerBox::pulses() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->box.begun;
}

int EmulatedTriggerBox::commands() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->commands;
}

}  // namespace rotunda::test
