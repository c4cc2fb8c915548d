#include "capture/sync/trigger_box.h"

#include <fmt/format.h>
#include <libusb.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <utility>

#include "config/errors.h"
#include "firmware/trigger_box/trigger_box_protocol.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

using Message = std::array<std::uint8_t, TRIGGER_BOX_MESSAGE_BYTES>;

constexpr auto kAnswerTime = 1s;          // a box answers within a millisecond; a second is a box that hangs
constexpr unsigned kListenMs = 50;        // how long one look for messages lasts
constexpr auto kClockInterval = 250ms;    // between readings of the box's clock
constexpr int kFirstReadings = 8;         // at the start, at once
constexpr std::uint8_t kClockTag = 0xFF;  // of the thread's own readings

[[noreturn]] void fail(const std::string& what) {
  throw DeviceError("trigger box", what);
}

void store(Message& message, std::size_t at, std::size_t bytes, std::uint64_t value) {
  for (std::size_t i = 0; i < bytes; ++i) message[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t load(const std::uint8_t* message, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(message[at + i]) << (8 * i);
  return value;
}

struct FreeContext {
  void operator()(libusb_context* context) const noexcept { libusb_exit(context); }
};
struct CloseHandle {
  void operator()(libusb_device_handle* handle) const noexcept {
    libusb_release_interface(handle, 0);
    libusb_close(handle);
  }
};
using Context = std::unique_ptr<libusb_context, FreeContext>;
using Handle = std::unique_ptr<libusb_device_handle, CloseHandle>;

Context usb_context() {
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error < 0)
    fail(fmt::format("USB cannot be used: {}", libusb_strerror(error)));
  return Context(context);
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
  Handle handle;  // empty: could not be opened
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

struct TriggerBox::Usb {
  Context context;
  Handle handle;
  unsigned char out = 0, in = 0;  // endpoints

  // A board's USB stack may give them numbers of its own.
  void find_endpoints() {
    libusb_config_descriptor* raw = nullptr;
    if (libusb_get_active_config_descriptor(libusb_get_device(handle.get()), &raw) != 0) return;
    const std::unique_ptr<libusb_config_descriptor, decltype(&libusb_free_config_descriptor)> configuration(
        raw, &libusb_free_config_descriptor);
    if (configuration->bNumInterfaces == 0 || configuration->interface[0].num_altsetting == 0) return;
    const auto& interface = configuration->interface[0].altsetting[0];
    for (int i = 0; i < interface.bNumEndpoints; ++i) {
      const auto& endpoint = interface.endpoint[i];
      if ((endpoint.bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
      auto& address = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0 ? in : out;
      if (address == 0) address = endpoint.bEndpointAddress;
    }
  }

  // Bytes moved; sets `error` when it was not a mere timeout.
  int transfer(unsigned char endpoint, Message& message, unsigned timeout_ms, int& error) const {
    int bytes = 0;
    error = libusb_bulk_transfer(handle.get(), endpoint, message.data(), static_cast<int>(message.size()), &bytes,
                                 timeout_ms);
    if (error == LIBUSB_ERROR_TIMEOUT || error == LIBUSB_ERROR_INTERRUPTED) error = 0;
    return bytes;
  }
};

std::vector<FoundTriggerBox> find_trigger_boxes() {
  const auto context = usb_context();
  std::vector<FoundTriggerBox> found;
  for (const auto& box : open_boxes(context.get())) found.push_back({box.serial, box.port});
  return found;
}

TriggerBox::TriggerBox(const std::string& serial, PulseSink sink)
    : usb_(std::make_unique<Usb>()), sink_(std::move(sink)) {
  usb_->context = usb_context();
  auto box = choose_box(open_boxes(usb_->context.get()), serial);
  serial_ = box.serial;
  usb_->handle = std::move(box.handle);
  if (const int error = libusb_claim_interface(usb_->handle.get(), 0); error < 0)
    fail(fmt::format("{} is in use by another program: {}", serial_, libusb_strerror(error)));
  usb_->find_endpoints();
  if (usb_->in == 0 || usb_->out == 0)
    fail(fmt::format("{} has no bulk endpoints; its firmware is not a trigger box's", serial_));
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
  Message message{};
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
  int error = 0;
  if (usb_->transfer(usb_->out, message, 1000, error) != TRIGGER_BOX_MESSAGE_BYTES)
    lose(error ? libusb_strerror(error) : "it takes no commands");
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
    Message message{};
    int error = 0;
    const int bytes = usb_->transfer(usb_->in, message, kListenMs, error);
    if (error) return lose(libusb_strerror(error));
    if (bytes == TRIGGER_BOX_MESSAGE_BYTES) take_message(message.data(), RigClock::now());
  }
}

void TriggerBox::read_clock() {
  Message message{};
  message[0] = TRIGGER_BOX_STATUS;
  message[1] = kClockTag;
  {
    const std::lock_guard lock(mutex_);
    clock_asked_ = RigClock::now();
  }
  int error = 0;
  usb_->transfer(usb_->out, message, 1000, error);
  if (error) lose(libusb_strerror(error));
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
