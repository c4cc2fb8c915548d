#include "capture/sync/trigger_box.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <utility>

#include "capture/sync/trigger_box_usb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr auto kAnswerTime = 1s;          // a box answers within a millisecond; a second is a box that hangs
constexpr auto kListen = 50ms;            // how long one look for messages lasts
constexpr auto kClockInterval = 250ms;    // between readings of the box's clock
constexpr int kFirstReadings = 8;         // at the start, at once
constexpr std::uint8_t kClockTag = 0xFF;  // of the thread's own readings

[[noreturn]] void fail(const std::string& what) {
  throw DeviceError("trigger box", what);
}

void store(TriggerBoxMessage& message, std::size_t at, std::size_t bytes, std::uint64_t value) {
  for (std::size_t i = 0; i < bytes; ++i) message[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t load(const std::uint8_t* message, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(message[at + i]) << (8 * i);
  return value;
}

std::string_view meaning(int status) {
  switch (status) {
    case TRIGGER_BOX_UNKNOWN_OPCODE:
      return "its firmware does not know the command; bring it up to date";
    case TRIGGER_BOX_OUT_OF_RANGE:
      return "the value is out of its range";
    case TRIGGER_BOX_BUSY:
      return "it is pulsing; stop it first";
    case TRIGGER_BOX_DOES_NOT_FIT:
      return "the pulse's width and the longest delay together must be shorter than the period";
    case TRIGGER_BOX_TOO_LATE:
      return "the moment asked for had passed";
    default:
      return "it did not understand";
  }
}

std::string_view name_of(int opcode) {
  constexpr std::array<std::string_view, 10> kNames = {"",          "hello",     "the period", "the width", "the count",
                                                       "the delay", "the lines", "start",      "stop",      "status"};
  return kNames.at(static_cast<std::size_t>(opcode));
}

}  // namespace

TriggerBox::TriggerBox(const std::string& serial, PulseSink sink)
    : usb_(std::make_unique<TriggerBoxUsb>(serial)), serial_(usb_->serial()), sink_(std::move(sink)) {
  thread_ = std::jthread([this](std::stop_token stop) { listen(std::move(stop)); });
  const auto hello = command({.opcode = TRIGGER_BOX_HELLO});
  if (hello.value32 >> 16 != TRIGGER_BOX_PROTOCOL)
    fail(fmt::format("{} speaks protocol {}, this program {}; bring the older up to date", serial_, hello.value32 >> 16,
                     TRIGGER_BOX_PROTOCOL));
  lines_ = static_cast<int>(hello.value32 & 0xFFFF);
  stop();
  for (int i = 0; i < kFirstReadings; ++i) {
    const Timestamp asked = RigClock::now();
    const auto reply = command({.opcode = TRIGGER_BOX_STATUS});
    const Timestamp answered = RigClock::now();
    const std::lock_guard lock(mutex_);
    clock_.add({asked, answered, reply.time});
  }
}

TriggerBox::~TriggerBox() {
  try {
    if (!lost_) stop();
  } catch (const DeviceError&) {  // it went while we were going: its own time limit ends the train
  }
}

TriggerBox::Reply TriggerBox::ask(const Request& request) {
  const std::lock_guard one_at_a_time(command_mutex_);
  TriggerBoxMessage message{};
  {
    const std::lock_guard lock(mutex_);
    tag_ = static_cast<std::uint8_t>(tag_ % (kClockTag - 1) + 1);
    reply_.reset();
    message[1] = tag_;
  }
  message[0] = request.opcode;
  store(message, 2, 2, request.line);
  store(message, 4, 4, request.value32);
  store(message, 8, 8, request.value64);
  if (const auto sent = usb_->send(message); !sent.whole)
    lose(sent.error.empty() ? "it takes no commands" : sent.error);
  std::unique_lock lock(mutex_);
  answered_.wait_for(lock, kAnswerTime, [&] { return reply_ || lost_; });
  if (lost_) fail(fmt::format("{} was lost: {}; plug it in again", serial_, why_lost_));
  if (!reply_) fail(fmt::format("{} does not answer; unplug it and plug it in again", serial_));
  return *reply_;
}

TriggerBox::Reply TriggerBox::command(const Request& request) {
  const auto reply = ask(request);
  if (reply.status != TRIGGER_BOX_OK) refuse(request, reply);
  return reply;
}

void TriggerBox::refuse(const Request& request, const Reply& reply) const {
  fail(fmt::format("{} refuses {}: {}", serial_, name_of(request.opcode), meaning(reply.status)));
}

PulseTrain TriggerBox::set(const PulseTrain& train) {
  const auto duration = [&](std::uint8_t opcode, std::uint16_t line, nanoseconds value) {
    const auto asked = static_cast<std::uint64_t>(std::max<std::int64_t>(value.count(), 0));
    return nanoseconds(static_cast<std::int64_t>(command({.opcode = opcode, .line = line, .value64 = asked}).value64));
  };
  if (train.delays.size() > static_cast<std::size_t>(lines_))
    fail(fmt::format("{} has {} lines, not {}", serial_, lines_, train.delays.size()));
  PulseTrain real = train;
  real.delays.resize(static_cast<std::size_t>(lines_));
  real.period = duration(TRIGGER_BOX_SET_PERIOD, 0, train.period);
  real.width = duration(TRIGGER_BOX_SET_WIDTH, 0, train.width);
  for (std::size_t line = 0; line < real.delays.size(); ++line)
    real.delays[line] = duration(TRIGGER_BOX_SET_DELAY, static_cast<std::uint16_t>(line), real.delays[line]);
  command({.opcode = TRIGGER_BOX_SET_LINES, .value32 = (1U << lines_) - 1U, .value64 = train.active_low});
  command({.opcode = TRIGGER_BOX_SET_COUNT, .value64 = train.count.value_or(0)});
  return real;
}

Timestamp TriggerBox::start(Timestamp at) {
  const auto model = clock();
  const auto moment = static_cast<std::uint64_t>(std::max<std::int64_t>(model.device_time(at).count(), 1));
  const auto reply = command({.opcode = TRIGGER_BOX_START, .value64 = moment});
  return model.rig_time(DeviceTime(static_cast<std::int64_t>(reply.value64)));
}

std::uint64_t TriggerBox::stop() {
  return command({.opcode = TRIGGER_BOX_STOP}).pulses;
}

TriggerBoxStatus TriggerBox::status() const {
  const std::lock_guard lock(mutex_);
  auto status = known_;
  status.lost = lost_;
  status.running = status.running && !lost_;
  status.drift_ppm = clock_.ready() ? clock_.drift_ppm() : 0.0;
  status.clock_error = clock_.ready() ? clock_.error() : nanoseconds{};
  return status;
}

ClockModel TriggerBox::clock() const {
  const std::lock_guard lock(mutex_);
  return clock_;
}

void TriggerBox::listen(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "trigger-box");
  auto next_reading = RigClock::now() + kClockInterval;
  while (!stop.stop_requested() && !lost_) {
    if (RigClock::now() >= next_reading) {
      read_clock();
      next_reading = RigClock::now() + kClockInterval;
    }
    TriggerBoxMessage message{};
    const auto received = usb_->receive(message, kListen);
    if (!received.error.empty()) return lose(received.error);
    if (received.whole) take_message(message.data(), RigClock::now());
  }
}

void TriggerBox::read_clock() {
  TriggerBoxMessage message{};
  message[0] = TRIGGER_BOX_STATUS;
  message[1] = kClockTag;
  {
    const std::lock_guard lock(mutex_);
    clock_asked_ = RigClock::now();
  }
  if (const auto sent = usb_->send(message); !sent.error.empty()) lose(sent.error);
}

void TriggerBox::take_message(const std::uint8_t* message, Timestamp arrived) {
  const Reply told{message[2],
                   message[3],
                   static_cast<std::uint32_t>(load(message, 4, 4)),
                   DeviceTime(static_cast<std::int64_t>(load(message, 8, 8))),
                   load(message, 16, 8),
                   load(message, 24, 8)};
  if (message[0] == TRIGGER_BOX_PULSE) return take_pulse(told);
  const std::lock_guard lock(mutex_);
  known_.running = told.state != TRIGGER_BOX_IDLE;
  known_.pulses = told.pulses;
  if (message[0] == (TRIGGER_BOX_STATUS | TRIGGER_BOX_REPLY)) known_.events_lost = told.value64;
  if (message[0] == TRIGGER_BOX_DONE) return;
  if (message[1] == kClockTag && clock_asked_) {
    clock_.add({*std::exchange(clock_asked_, std::nullopt), arrived, told.time});
  } else if (message[1] == tag_) {
    reply_ = told;
    answered_.notify_all();
  }
}

void TriggerBox::take_pulse(const Reply& event) {
  Pulse pulse{.number = event.pulses, .late = nanoseconds(static_cast<std::int64_t>(event.value64))};
  {
    const std::lock_guard lock(mutex_);
    if (!clock_.ready()) return;  // of a train that ran before we came
    pulse.time = clock_.rig_time(event.time);
    known_.pulses = event.pulses + 1;
  }
  if (sink_) sink_(pulse);
}

void TriggerBox::lose(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (!lost_) why_lost_ = why;
  lost_ = true;
  answered_.notify_all();
}

}  // namespace rotunda::capture
