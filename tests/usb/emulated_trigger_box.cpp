#include "tests/usb/emulated_trigger_box.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/trigger_box/trigger_box.h"
#include "tests/usb/mocked_usb_device.h"

namespace rotunda::tests {
namespace {

using Bytes = std::vector<std::uint8_t>;

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

// A string descriptor in UTF-16; number 0 lists the languages.
Bytes string_descriptor(unsigned number, const std::string& serial) {
  Bytes text{0, 3};
  if (number == 0) put16(text, 0x0409);
  for (std::size_t i = 0; number != 0 && i < serial.size(); ++i) put16(text, static_cast<unsigned char>(serial[i]));
  text[0] = static_cast<std::uint8_t>(text.size());
  return text;
}

}  // namespace

struct EmulatedTriggerBox::Parts {
  EmulatedTriggerBoxOptions options;
  OnEdge on_edge;
  mutable std::mutex mutex;  // guards what follows; taken after the mocked device's
  std::condition_variable_any changed;
  trigger_box box{};
  std::deque<std::pair<unsigned, bool>> edges;  // of the advance under way
  std::deque<Bytes> replies;
  bool gone = false, deaf = false;
  int commands = 0;
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  std::unique_ptr<MockedUsbDevice> usb;
  std::jthread timer;

  explicit Parts(const EmulatedTriggerBoxOptions& chosen, OnEdge on_edge_)
      : options(chosen), on_edge(std::move(on_edge_)) {
    trigger_box_init(&box, options.lines, 8000, &Parts::set_line, this);
    edges.clear();
    usb = std::make_unique<MockedUsbDevice>(
        MockedUsbOptions{.serial = options.serial, .descriptors = descriptors()},
        MockedUsbFunctions{.string = [this](unsigned number) { return string_descriptor(number, options.serial); },
                           .receive = [this](unsigned, std::span<const std::uint8_t> message) { obey(message); },
                           .send = [this](unsigned) { return message(); }});
    timer = std::jthread([this](std::stop_token stop) { run_timer(std::move(stop)); });
  }
  ~Parts() {
    timer.request_stop();
    timer.join();
    usb.reset();
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
      const auto happened = std::exchange(edges, {});
      lock.unlock();
      usb->serve();
      for (const auto& [line, high] : happened)
        if (on_edge) on_edge(line, high);
      lock.lock();
    }
  }

  void obey(std::span<const std::uint8_t> message) {
    const std::lock_guard lock(mutex);
    ++commands;
    if (deaf) return;
    auto& reply = replies.emplace_back(TRIGGER_BOX_MESSAGE_BYTES);
    trigger_box_command(&box, message.data(), message.size(), now(), reply.data());
    changed.notify_all();
  }

  // Replies before events, as a full IN endpoint would have sent them.
  std::optional<Bytes> message() {
    const std::lock_guard lock(mutex);
    Bytes next(TRIGGER_BOX_MESSAGE_BYTES);
    if (!replies.empty()) {
      next = std::move(replies.front());
      replies.pop_front();
      return next;
    }
    if (!trigger_box_pop_event(&box, next.data())) return std::nullopt;
    return next;
  }
};

EmulatedTriggerBox::EmulatedTriggerBox(const EmulatedTriggerBoxOptions& options, OnEdge on_edge)
    : parts_(std::make_unique<Parts>(options, std::move(on_edge))) {}

EmulatedTriggerBox::~EmulatedTriggerBox() = default;

void EmulatedTriggerBox::unplug() {
  parts_->usb->unplug();
  const std::lock_guard lock(parts_->mutex);
  parts_->gone = true;
  trigger_box_unplugged(&parts_->box);
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

}  // namespace rotunda::tests
