#include "simulator/gige/gige_device.h"

#include <algorithm>
#include <cmath>

#include "simulator/gige/big_endian.h"
#include "simulator/gige/gvsp.h"

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr nanoseconds kReadout = 500us;       // from the exposure's end to the first packet
constexpr nanoseconds kFurthestAction = 60s;  // a schedule beyond is taken for another clock's time
constexpr nanoseconds kFreeRunBacklog = 1s;   // a process held up for longer does not make up for its frames
constexpr std::size_t kMaxPending = 16;       // scheduled exposures
constexpr std::size_t kMaxErrands = 256;      // resend requests and test packets waiting for the sender
constexpr std::uint32_t kExclusive = 1;       // control privilege: others may not even read
constexpr std::uint32_t kControl = 2;         // control privilege: others may read
constexpr std::uint32_t kLatch = 2;           // timestamp control
constexpr std::uint32_t kMilliCelsius = 41'500;
constexpr Endpoint kThief{.address = 0xC0000201, .port = 1};  // 192.0.2.1, for documentation: nobody sends from there

std::vector<std::uint8_t> written(const GvcpCommand& command, GvcpStatus status, std::size_t count) {
  std::vector<std::uint8_t> payload(4);
  store_be(std::span{payload}, 2, static_cast<std::uint16_t>(count));
  return gvcp_acknowledge(command, status, payload);
}

}  // namespace

GigeDevice::GigeDevice(const GigeCameraOptions& options, PtpStatus ptp, std::uint16_t stream_source_port)
    : options_(options), ptp_(ptp), stream_source_port_(stream_source_port), registers_(options) {
  power_up();
}

void GigeDevice::power_up() {
  registers_ = DeviceRegisters(options_);
  registers_.set(reg::kSourcePort, stream_source_port_);
  registers_.set(reg::kPtpEnable, 1);
  registers_.set(reg::kPtpStatus, static_cast<std::uint32_t>(ptp_));
  registers_.set(reg::kTemperature, kMilliCelsius);
}

// --- commands ---------------------------------------------------------------------------------------------------

std::optional<std::vector<std::uint8_t>> GigeDevice::handle(std::span<const std::uint8_t> datagram, Endpoint from,
                                                            Timestamp received) {
  advance(received);
  const auto wrong = faults_.in_force(received);
  if (wrong.is_away()) {
    if (wrong.silent) ++counts_.faults[FaultKind::silence];
    return std::nullopt;
  }
  const auto command = parse_gvcp(datagram);
  if (!command) return std::nullopt;
  if (controller_ == from) last_heard_ = received;
  const bool is_write = command->opcode == GvcpOpcode::write_register || command->opcode == GvcpOpcode::write_memory;
  if (is_write && last_write_.from == from &&
      std::equal(datagram.begin(), datagram.end(), last_write_.command.begin(), last_write_.command.end()))
    return last_write_.acknowledgement;
  auto acknowledgement = answer(*command, from, received);
  if (is_write && acknowledgement) last_write_ = {from, {datagram.begin(), datagram.end()}, *acknowledgement};
  if (!command->wants_ack() && command->opcode != GvcpOpcode::discovery) return std::nullopt;
  return acknowledgement;
}

GigeDevice::Acknowledgement GigeDevice::answer(const GvcpCommand& command, Endpoint from, Timestamp received) {
  switch (command.opcode) {
    case GvcpOpcode::discovery:
      return gvcp_acknowledge(command, GvcpStatus::success, registers_.discovery());
    case GvcpOpcode::force_ip:
      return force_ip(command);
    case GvcpOpcode::packet_resend:
      note_resend(command);
      return std::nullopt;
    case GvcpOpcode::read_register:
      return read_registers(command, from, received);
    case GvcpOpcode::write_register:
      return write_registers(command, from, received);
    case GvcpOpcode::read_memory:
      return read_memory(command, from, received);
    case GvcpOpcode::write_memory:
      return write_memory(command, from, received);
    case GvcpOpcode::action:
      return act(command, received);
    case GvcpOpcode::pending:
      break;
  }
  return gvcp_acknowledge(command, GvcpStatus::not_implemented);
}

GigeDevice::Acknowledgement GigeDevice::read_registers(const GvcpCommand& command, Endpoint from, Timestamp received) {
  if (!may_read(from)) return gvcp_acknowledge(command, GvcpStatus::access_denied);
  if (command.payload.empty() || command.payload.size() % 4 != 0 || command.payload.size() > kGvcpMaxReadBytes)
    return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  std::vector<std::uint8_t> values;
  for (std::size_t at = 0; at < command.payload.size(); at += 4) {
    const auto address = load_be<std::uint32_t>(command.payload, at);
    if (address % 4 != 0) return gvcp_acknowledge(command, GvcpStatus::bad_alignment, values);
    const auto word = registers_.read(address, 4);
    if (!word) return gvcp_acknowledge(command, GvcpStatus::invalid_address, values);
    values.insert(values.end(), word->begin(), word->end());
    falsify(address, std::span{values}.last(4), received);
  }
  return gvcp_acknowledge(command, GvcpStatus::success, values);
}

GigeDevice::Acknowledgement GigeDevice::read_memory(const GvcpCommand& command, Endpoint from, Timestamp received) {
  if (!may_read(from)) return gvcp_acknowledge(command, GvcpStatus::access_denied);
  if (command.payload.size() < 8) return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  const auto address = load_be<std::uint32_t>(command.payload, 0);
  const std::size_t bytes = load_be<std::uint16_t>(command.payload, 6);
  if (bytes == 0 || bytes % 4 != 0 || bytes > kGvcpMaxReadBytes)
    return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  if (address % 4 != 0) return gvcp_acknowledge(command, GvcpStatus::bad_alignment);
  const auto memory = registers_.read(address, bytes);
  if (!memory) return gvcp_acknowledge(command, GvcpStatus::invalid_address);
  std::vector<std::uint8_t> payload(command.payload.begin(), command.payload.begin() + 4);
  payload.insert(payload.end(), memory->begin(), memory->end());
  falsify(address, std::span{payload}.subspan(4), received);
  return gvcp_acknowledge(command, GvcpStatus::success, payload);
}

GigeDevice::Acknowledgement GigeDevice::write_registers(const GvcpCommand& command, Endpoint from, Timestamp received) {
  if (command.payload.empty() || command.payload.size() % 8 != 0)
    return written(command, GvcpStatus::invalid_parameter, 0);
  for (std::size_t at = 0; at < command.payload.size(); at += 8) {
    const auto status = write_word(load_be<std::uint32_t>(command.payload, at),
                                   load_be<std::uint32_t>(command.payload, at + 4), from, received);
    if (status != GvcpStatus::success) return written(command, status, at / 8);
  }
  return written(command, GvcpStatus::success, command.payload.size() / 8);
}

GigeDevice::Acknowledgement GigeDevice::write_memory(const GvcpCommand& command, Endpoint from, Timestamp received) {
  if (command.payload.size() < 8 || command.payload.size() % 4 != 0)
    return written(command, GvcpStatus::invalid_parameter, 0);
  const auto address = load_be<std::uint32_t>(command.payload, 0);
  const auto data = command.payload.subspan(4);
  for (std::size_t at = 0; at < data.size(); at += 4) {
    const auto status =
        write_word(address + static_cast<std::uint32_t>(at), load_be<std::uint32_t>(data, at), from, received);
    if (status != GvcpStatus::success) return written(command, status, at);
  }
  return written(command, GvcpStatus::success, data.size());
}

// A simulated camera keeps the address it was made for: asking for that one, or for none, is granted.
GigeDevice::Acknowledgement GigeDevice::force_ip(const GvcpCommand& command) const {
  const auto request = parse_force_ip(command);
  if (!request) return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  const std::uint64_t mac =
      static_cast<std::uint64_t>(registers_.get(reg::kMacHigh)) << 32 | registers_.get(reg::kMacLow);
  if (request->mac != mac) return std::nullopt;
  const bool granted = request->address == 0 || request->address == registers_.get(reg::kAddress);
  return gvcp_acknowledge(command, granted ? GvcpStatus::success : GvcpStatus::not_implemented);
}

void GigeDevice::note_resend(const GvcpCommand& command) {
  const auto request = parse_resend(command);
  if (!request || !controller_ || resends_.size() >= kMaxErrands) return;
  ++counts_.resend_requests;
  resends_.push_back(*request);
}

// --- access and registers ---------------------------------------------------------------------------------------

bool GigeDevice::may_read(Endpoint from) const {
  const bool exclusive = (registers_.get(reg::kControlPrivilege) & kExclusive) != 0;
  return !exclusive || controller_ == from;
}

GvcpStatus GigeDevice::write_word(std::uint32_t address, std::uint32_t value, Endpoint from, Timestamp received) {
  if (address % 4 != 0) return GvcpStatus::bad_alignment;
  if (address == reg::kControlPrivilege) return change_privilege(value, from, received);
  const bool locked = acquiring_ && address == reg::kPixelFormat;
  if (controller_ != from || locked) {
    ++counts_.denied;
    return GvcpStatus::access_denied;
  }
  const auto status = registers_.write(address, value);
  if (status == GvcpStatus::success) react(address, value, received);
  return status;
}

GvcpStatus GigeDevice::change_privilege(std::uint32_t value, Endpoint from, Timestamp received) {
  if (controller_ && controller_ != from) {
    ++counts_.denied;
    return GvcpStatus::access_denied;
  }
  const auto status = registers_.write(reg::kControlPrivilege, value);
  if (status != GvcpStatus::success) return status;
  if (value == 0) {
    release_control();
  } else {
    controller_ = from;
    last_heard_ = received;
  }
  return status;
}

void GigeDevice::release_control() {
  stop_acquisition();
  controller_.reset();
  last_write_ = {};
  resends_.clear();
  test_packets_.clear();
  registers_.set(reg::kControlPrivilege, 0);
  registers_.set(reg::kHostPort, 0);
}

void GigeDevice::check_heartbeat(Timestamp now) {
  if (!controller_ || controller_ == kThief ||
      now - last_heard_ < std::chrono::milliseconds{registers_.get(reg::kHeartbeatMs)})
    return;
  ++counts_.lost_controllers;
  release_control();
}

void GigeDevice::react(std::uint32_t address, std::uint32_t value, Timestamp received) {
  const auto latch = [&] {
    registers_.set64(reg::kTimestampHigh, static_cast<std::uint64_t>(camera_time(received).time_since_epoch().count()));
  };
  switch (address) {
    case reg::kAcquisitionStart:
      if (value == 1) start_acquisition(received);
      break;
    case reg::kAcquisitionStop:
      if (value == 1) stop_acquisition();
      break;
    case reg::kTriggerSoftware:
      if (value == 1) trigger(TriggerSource::software, received);
      break;
    case reg::kTriggerMode:
      next_free_run_.reset();
      if (acquiring_ && value == 0) next_free_run_ = received;
      break;
    case reg::kTimestampControl:
      if ((value & kLatch) != 0) latch();
      break;
    case reg::kTimestampLatch:
      if (value == 1) latch();
      break;
    case reg::kPtpEnable:
      registers_.set(reg::kPtpStatus, static_cast<std::uint32_t>(value == 1 ? ptp_ : PtpStatus::disabled));
      return;
    case reg::kPacketSize:
      fire_test_packet(value);
      return;
    default:
      return;
  }
  if (address != reg::kTriggerMode) registers_.set(address, 0);  // commands clear themselves
}

void GigeDevice::fire_test_packet(std::uint32_t value) {
  registers_.set(reg::kPacketSize, value & ~kFireTestPacket);
  if ((value & kFireTestPacket) == 0 || test_packets_.size() >= kMaxErrands) return;
  constexpr std::size_t kIpAndUdp = 28;
  test_packets_.push_back({stream_destination(), (value & kPacketSizeMask) - kIpAndUdp});
}

void GigeDevice::start_acquisition(Timestamp at) {
  stop_acquisition();
  acquiring_ = true;
  const auto mode = static_cast<AcquisitionMode>(registers_.get(reg::kAcquisitionMode));
  if (mode == AcquisitionMode::single_frame) frames_left_ = 1;
  if (mode == AcquisitionMode::multi_frame) frames_left_ = registers_.get(reg::kFrameCount);
  if (registers_.get(reg::kTriggerMode) == 0) next_free_run_ = at;
}

void GigeDevice::stop_acquisition() {
  acquiring_ = false;
  last_block_ = 0;
  frames_left_.reset();
  next_free_run_.reset();
  last_start_.reset();
  pending_.clear();
  heard_.clear();
}

// --- triggers ---------------------------------------------------------------------------------------------------

GigeDevice::Acknowledgement GigeDevice::act(const GvcpCommand& command, Timestamp received) {
  const auto action = parse_action(command);
  if (!action) return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  const bool meant = action->device_key == registers_.get(reg::kActionDeviceKey) &&
                     action->group_key == registers_.get(reg::kActionGroupKey) &&
                     (action->group_mask & registers_.get(reg::kActionGroupMask)) != 0;
  if (!meant) return std::nullopt;
  return gvcp_acknowledge(command, carry_out(*action, received));
}

GvcpStatus GigeDevice::carry_out(const ActionCommand& action, Timestamp received) {
  if (!action.at) return trigger(TriggerSource::action1, received);
  if (registers_.get(reg::kPtpEnable) == 0) return GvcpStatus::no_reference_time;
  if (*action.at > received + kFurthestAction) return GvcpStatus::invalid_parameter;
  const Timestamp at = *action.at - faults_.clock_error(*action.at);  // when the camera's clock shows it
  const bool late = at < received;
  const auto status = trigger(TriggerSource::action1, late ? received : at);
  if (!late) return status;
  ++counts_.late_actions;
  return GvcpStatus::action_late;
}

void GigeDevice::line0_edge(Timestamp at) {
  trigger(TriggerSource::line0, at);
}

GvcpStatus GigeDevice::trigger(TriggerSource source, Timestamp at) {
  if (!is_armed_for(source) || was_heard(at) || overlaps_another(at)) {
    ++counts_.ignored_triggers;
    return GvcpStatus::success;
  }
  if (pending_.size() >= kMaxPending) return GvcpStatus::overflow;
  ++counts_.triggers;
  heard_.push_back(at);
  if (heard_.size() > kMaxPending) heard_.pop_front();
  const auto number = faults_.note_trigger(at);
  const auto wrong = faults_.in_force(at);
  if (wrong.missed_trigger.every != 0 && number % wrong.missed_trigger.every == 0) {
    ++counts_.faults[FaultKind::missed_trigger];
    return GvcpStatus::success;
  }
  counts_.faults[FaultKind::late_trigger] += wrong.late_trigger.by.count() != 0;
  const Timestamp start = at + wrong.late_trigger.by;
  expose(start);
  const auto& doubled = wrong.doubled_trigger;
  if (doubled.every != 0 && number % doubled.every == 0 && !overlaps_another(start + doubled.after)) {
    ++counts_.faults[FaultKind::doubled_trigger];
    expose(start + doubled.after);
  }
  return GvcpStatus::success;
}

void GigeDevice::expose(Timestamp start) {
  pending_.insert(std::upper_bound(pending_.begin(), pending_.end(), start), start);
}

// One action sent twice is one trigger, also if nothing came of the first.
bool GigeDevice::was_heard(Timestamp at) const {
  return std::find(heard_.begin(), heard_.end(), at) != heard_.end();
}

bool GigeDevice::is_armed_for(TriggerSource source) const {
  return acquiring_ && registers_.get(reg::kTriggerMode) == 1 &&
         registers_.get(reg::kTriggerSource) == static_cast<std::uint32_t>(source);
}

bool GigeDevice::overlaps_another(Timestamp start) const {
  const auto near = [&](Timestamp other) { return std::chrono::abs(start - other) < exposure(); };
  return (last_start_ && near(*last_start_)) || std::any_of(pending_.begin(), pending_.end(), near);
}

// --- frames -----------------------------------------------------------------------------------------------------

nanoseconds GigeDevice::exposure() const {
  return nanoseconds{registers_.get(reg::kExposureTime)};
}

nanoseconds GigeDevice::busy_time() const {
  return exposure() + kReadout;
}

nanoseconds GigeDevice::free_run_period() const {
  const bool limited = registers_.get(reg::kFrameRateEnable) == 1;
  const nanoseconds wanted{limited ? 1'000'000'000'000 / registers_.get(reg::kFrameRate)
                                   : 8ULL * registers_.get(reg::kPayloadSize)};  // else what 1 Gb/s carries
  return std::max(wanted, busy_time());
}

Endpoint GigeDevice::stream_destination() const {
  return {.address = registers_.get(reg::kDestination),
          .port = static_cast<std::uint16_t>(registers_.get(reg::kHostPort))};
}

std::optional<Timestamp> GigeDevice::next_due() const {
  std::optional<Timestamp> start = next_free_run_;
  if (!pending_.empty() && (!start || pending_.front() < *start)) start = pending_.front();
  if (!start) return std::nullopt;
  return *start + busy_time();
}

void GigeDevice::skip_missed_free_run(Timestamp now) {
  if (!next_free_run_ || now - *next_free_run_ < kFreeRunBacklog) return;
  const auto period = free_run_period();
  *next_free_run_ += (now - *next_free_run_) / period * period;
}

std::optional<DueFrame> GigeDevice::take_due(Timestamp now) {
  advance(now);
  for (;;) {
    auto frame = next_frame(now);
    if (!frame || !withholds(*frame)) return frame;
  }
}

std::optional<DueFrame> GigeDevice::next_frame(Timestamp now) {
  skip_missed_free_run(now);
  const auto due = next_due();
  if (!due || *due > now) return std::nullopt;
  const Timestamp start = *due - busy_time();
  if (!pending_.empty() && pending_.front() == start) {
    pending_.pop_front();
  } else {
    *next_free_run_ += free_run_period();
    faults_.note_trigger(start);
  }
  DueFrame frame = frame_at(start);
  if (frames_left_ && --*frames_left_ == 0) stop_acquisition();
  return frame;
}

DueFrame GigeDevice::frame_at(Timestamp start) {
  last_start_ = start;
  last_block_ = last_block_ == 65535 ? std::uint16_t{1} : static_cast<std::uint16_t>(last_block_ + 1);
  const auto wrong = faults_.in_force(start);
  counts_.faults[FaultKind::clock_drift] += wrong.clock_drifts;
  return {.block = last_block_,
          .exposure_start = start,
          .due = start + busy_time(),
          .exposure = exposure(),
          .stamp = start + wrong.clock_error,
          .destination = stream_destination(),
          .packet_size = registers_.get(reg::kPacketSize) & kPacketSizeMask,
          .pixel_code = registers_.get(reg::kPixelFormat),
          .width = registers_.get(reg::kWidth),
          .height = registers_.get(reg::kHeight),
          .packet_delay = nanoseconds{registers_.get(reg::kPacketDelay)},
          .faults = wrong};
}

std::optional<ResendCommand> GigeDevice::take_resend() {
  if (resends_.empty()) return std::nullopt;
  const auto request = resends_.front();
  resends_.pop_front();
  return request;
}

std::optional<TestPacket> GigeDevice::take_test_packet() {
  if (test_packets_.empty()) return std::nullopt;
  const auto packet = test_packets_.front();
  test_packets_.pop_front();
  return packet;
}

// --- faults -----------------------------------------------------------------------------------------------------

void GigeDevice::advance(Timestamp now) {
  for (const auto& edge : faults_.take_edges(now)) {
    if (edge.kind == FaultKind::reboot && edge.begins) reboot();
    if (edge.kind == FaultKind::control_stolen) edge.begins ? steal_control(edge.at) : return_control();
    counts_.faults[FaultKind::over_temperature] += edge.kind == FaultKind::over_temperature && edge.begins;
    counts_.faults[FaultKind::clock_step] += edge.kind == FaultKind::clock_step && edge.begins;
  }
}

void GigeDevice::reboot() {
  ++counts_.faults[FaultKind::reboot];
  release_control();
  power_up();
}

// As when the controller's heartbeat was held up and somebody else was quicker.
void GigeDevice::steal_control(Timestamp at) {
  ++counts_.faults[FaultKind::control_stolen];
  release_control();
  const auto theft = faults_.in_force(at).control_stolen;
  controller_ = kThief;
  registers_.set(reg::kControlPrivilege, theft && !theft->exclusive ? kControl : kExclusive);
}

void GigeDevice::return_control() {
  if (controller_ == kThief) release_control();
}

std::uint32_t GigeDevice::temperature(Timestamp at) const {
  const auto wrong = faults_.in_force(at);
  const double usual = registers_.get(reg::kTemperature);
  if (!wrong.heat) return static_cast<std::uint32_t>(usual);
  const double risen = usual + (wrong.heat->fault.celsius * 1000.0 - usual) * wrong.heat->progress;
  return static_cast<std::uint32_t>(std::lround(std::max(0.0, risen)));
}

// What a client reads of `memory`, which lies at `address`, instead of what is there.
void GigeDevice::falsify(std::uint32_t address, std::span<std::uint8_t> memory, Timestamp at) {
  const auto tell = [&](std::uint32_t where, std::uint32_t value) {
    if (where >= address && where - address < memory.size()) store_be(memory, where - address, value);
  };
  const auto wrong = faults_.in_force(at);
  if (wrong.heat) tell(reg::kTemperature, temperature(at));
  const auto change = wrong.wrong_payload_size.register_change;
  if (change == 0 || reg::kPayloadSize < address || reg::kPayloadSize - address >= memory.size()) return;
  ++counts_.faults[FaultKind::wrong_payload_size];
  tell(reg::kPayloadSize,
       static_cast<std::uint32_t>(std::max<std::int64_t>(0, registers_.get(reg::kPayloadSize) + change)));
}

// Frames that are exposed and never leave.
bool GigeDevice::withholds(const DueFrame& frame) {
  const auto& wrong = frame.faults;
  const bool too_hot = wrong.heat && wrong.heat->fault.stops_at &&
                       temperature(frame.exposure_start) >= *wrong.heat->fault.stops_at * 1000.0;
  if (wrong.stalled)
    ++counts_.faults[FaultKind::stall];
  else if (too_hot)
    ++counts_.faults[FaultKind::over_temperature];
  return wrong.stalled || too_hot;
}

}  // namespace rotunda::simulator
