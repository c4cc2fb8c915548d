#include "tests/vm/trigger_box_gadget.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace rotunda::vm {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kStepPs = 8000;  // of an RP2040's clock at 125 MHz
constexpr auto kLook = 20ms;             // how often a thread sees that it is to end

UsbGadgetOptions options_for(const std::string& serial) {
  return {.name = "box", .vendor = TRIGGER_BOX_VENDOR_ID, .product = TRIGGER_BOX_PRODUCT_ID, .serial = serial};
}

}  // namespace

TriggerBoxGadget::TriggerBoxGadget(const std::string& serial, unsigned lines) : gadget_(options_for(serial)) {
  trigger_box_init(&box_, lines, kStepPs, &TriggerBoxGadget::set_line, this);
  obey_ = std::jthread([this](const std::stop_token& stop) { obey(stop); });
  answer_ = std::jthread([this](const std::stop_token& stop) { answer(stop); });
  keep_time_ = std::jthread([this](const std::stop_token& stop) { keep_time(stop); });
  plug_in();
}

TriggerBoxGadget::~TriggerBoxGadget() {
  for (auto* thread : {&obey_, &answer_, &keep_time_}) thread->request_stop();
  try {
    gadget_.unplug();                   // ends the transfers that threads wait in
  } catch (const std::system_error&) {  // it was already
  }
}

void TriggerBoxGadget::plug_in() {
  gadget_.plug_in();
}

void TriggerBoxGadget::unplug() {
  gadget_.unplug();
  const std::lock_guard lock(mutex_);
  trigger_box_unplugged(&box_);
  replies_.clear();
}

void TriggerBoxGadget::set_line(void* self, unsigned line, bool high, std::uint64_t at) {
  static_cast<TriggerBoxGadget*>(self)->edges_.push_back({line, high, at});
}

std::uint64_t TriggerBoxGadget::now() const {
  return static_cast<std::uint64_t>(
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count());
}

std::vector<LineEdge> TriggerBoxGadget::edges() const {
  const std::lock_guard lock(mutex_);
  return edges_;
}

std::uint64_t TriggerBoxGadget::pulses() const {
  const std::lock_guard lock(mutex_);
  return box_.begun;
}

bool TriggerBoxGadget::pulsing() const {
  const std::lock_guard lock(mutex_);
  return box_.state != TRIGGER_BOX_IDLE;
}

// The firmware's OUT endpoint.
void TriggerBoxGadget::obey(const std::stop_token& stop) {
  std::array<std::uint8_t, 64> message{};
  while (!stop.stop_requested()) {
    std::size_t size = 0;
    if (!gadget_.receive(message.data(), message.size(), size)) {
      std::this_thread::sleep_for(kLook);
      continue;
    }
    const std::lock_guard lock(mutex_);
    if (message[0] == TRIGGER_BOX_START && box_.state == TRIGGER_BOX_IDLE) edges_.clear();
    auto& reply = replies_.emplace_back(TRIGGER_BOX_MESSAGE_BYTES);
    trigger_box_command(&box_, message.data(), size, now(), reply.data());
    changed_.notify_all();
  }
}

// Its IN endpoint: replies before events.
void TriggerBoxGadget::answer(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<std::uint8_t> message(TRIGGER_BOX_MESSAGE_BYTES);
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, kLook, [&] { return !replies_.empty() || box_.waiting > 0; });
      if (!replies_.empty()) {
        message = replies_.front();
        replies_.pop_front();
      } else if (!trigger_box_pop_event(&box_, message.data())) {
        continue;
      }
    }
    if (!gadget_.send(message.data(), message.size())) std::this_thread::sleep_for(kLook);
  }
}

// Its timer's interrupt.
void TriggerBoxGadget::keep_time(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    std::uint64_t next = 0;
    const std::uint64_t time = now();
    const bool due = trigger_box_next_edge(&box_, &next);
    if (due && next <= time) {
      trigger_box_advance(&box_, time);
      changed_.notify_all();
    }
    const auto wait = due && next > time
                          ? std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(next - time), kLook)
                          : std::chrono::nanoseconds(due ? 0ms : kLook);
    changed_.wait_for(lock, stop, wait, [] { return false; });
  }
}

}  // namespace rotunda::vm
