#include "simulator/gige/gige_device.h"

#include <algorithm>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr std::size_t kMaxResends = 256;  // waiting for the sender
constexpr std::size_t kMaxLate = 256;     // acknowledgements
constexpr nanoseconds kPulse = 100us;     // of a trigger box
// Control privilege: others may not even read; others may read; who knows the key in the upper half may take over.
constexpr std::uint32_t kExclusive = 1, kControl = 2, kSwitchover = 4, kPrivileges = 7;
constexpr Endpoint kThief{.address = 0xC0000201, .port = 1};  // 192.0.2.1, for documentation: nobody sends from there

bool is_of_registers(const GvcpCommand& command) {
  return command.opcode >= GvcpOpcode::read_register && command.opcode <= GvcpOpcode::write_memory;
}

std::vector<std::uint8_t> written(const GvcpCommand& command, GvcpStatus status, std::size_t count) {
  std::vector<std::uint8_t> payload(4);
  store_be(std::span{payload}, 2, static_cast<std::uint16_t>(count));
  return gvcp_acknowledge(command, status, payload);
}

}  // namespace

GigeDevice::GigeDevice(const GigeCameraOptions& options, PtpStatus role, std::uint16_t stream_source_port,
                       Timestamp powered_up)
    : camera_(options, role, stream_source_port, powered_up) {}

// --- commands ---------------------------------------------------------------------------------------------------

std::optional<std::vector<std::uint8_t>> GigeDevice::handle(std::span<const std::uint8_t> datagram, Endpoint from,
                                                            Timestamp received) {
  advance(received);
  const auto wrong = faults().in_force(received);
  if (wrong.is_away()) {
    if (wrong.silent) ++camera_.counts().faults[FaultKind::silence];
    return std::nullopt;
  }
  const auto command = parse_gvcp(datagram);
  if (!command) return std::nullopt;
  if (controller_ == from) last_heard_ = received;
  const bool is_write = command->opcode == GvcpOpcode::write_register || command->opcode == GvcpOpcode::write_memory;
  auto acknowledgement = is_write ? answer_write(*command, datagram, from, received) : answer(*command, from, received);
  if (!command->wants_ack() && command->opcode != GvcpOpcode::discovery) return std::nullopt;
  const nanoseconds slow = is_of_registers(*command) ? wrong.slow_registers.by : 0ns;
  if (slow.count() > 0 && acknowledgement) return slowed(*command, std::move(*acknowledgement), from, received, slow);
  return acknowledgement;
}

GigeDevice::Acknowledgement GigeDevice::answer_write(const GvcpCommand& command, std::span<const std::uint8_t> datagram,
                                                     Endpoint from, Timestamp received) {
  const bool repeated = last_write_.from == from && std::equal(datagram.begin(), datagram.end(),
                                                               last_write_.command.begin(), last_write_.command.end());
  if (repeated) return received < last_write_.done ? last_write_.first : last_write_.last;
  auto acknowledgement = answer(command, from, received);
  last_write_ = {from, {datagram.begin(), datagram.end()}, acknowledgement, acknowledgement, received};
  const nanoseconds effort = camera_.take_effort();
  if (effort.count() == 0 || !acknowledgement) return acknowledgement;
  last_write_.done = received + effort;
  last_write_.first = pending(command, effort);
  if (command.wants_ack()) acknowledge_late({last_write_.done, std::move(*acknowledgement), from});
  return last_write_.first;
}

// Nothing if the client does not understand it.
GigeDevice::Acknowledgement GigeDevice::pending(const GvcpCommand& command, nanoseconds effort) {
  if ((camera_.registers().get(reg::kGvcpConfiguration) & kPendingAckEnable) == 0) return std::nullopt;
  ++camera_.counts().pending_acks;
  return gvcp_pending(command, std::chrono::ceil<std::chrono::milliseconds>(effort));
}

void GigeDevice::acknowledge_late(LateAcknowledgement acknowledgement) {
  if (late_.size() >= kMaxLate) return;
  const auto after =
      std::upper_bound(late_.begin(), late_.end(), acknowledgement.when,
                       [](Timestamp when, const LateAcknowledgement& other) { return when < other.when; });
  late_.insert(after, std::move(acknowledgement));
}

std::optional<Timestamp> GigeDevice::next_late_acknowledgement() const {
  if (late_.empty()) return std::nullopt;
  return late_.front().when;
}

std::optional<LateAcknowledgement> GigeDevice::take_late_acknowledgement(Timestamp now) {
  if (faults().in_force(now).is_away()) late_.clear();
  if (late_.empty() || late_.front().when > now) return std::nullopt;
  auto taken = std::move(late_.front());
  late_.pop_front();
  return taken;
}

GigeDevice::Acknowledgement GigeDevice::answer(const GvcpCommand& command, Endpoint from, Timestamp received) {
  switch (command.opcode) {
    case GvcpOpcode::discovery:
      return gvcp_acknowledge(command, GvcpStatus::success, camera_.registers().discovery());
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
    const auto word = camera_.read(address, 4, received);
    if (!word) return gvcp_acknowledge(command, GvcpStatus::invalid_address, values);
    values.insert(values.end(), word->begin(), word->end());
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
  const auto memory = camera_.read(address, bytes, received);
  if (!memory) return gvcp_acknowledge(command, GvcpStatus::invalid_address);
  std::vector<std::uint8_t> payload(command.payload.begin(), command.payload.begin() + 4);
  payload.insert(payload.end(), memory->begin(), memory->end());
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
  const auto& registers = camera_.registers();
  const std::uint64_t mac =
      static_cast<std::uint64_t>(registers.get(reg::kMacHigh)) << 32 | registers.get(reg::kMacLow);
  if (request->mac != mac) return std::nullopt;
  const bool granted = request->address == 0 || request->address == registers.get(reg::kAddress);
  return gvcp_acknowledge(command, granted ? GvcpStatus::success : GvcpStatus::not_implemented);
}

void GigeDevice::note_resend(const GvcpCommand& command) {
  const auto request = parse_resend(command);
  if (!request || !controller_ || resends_.size() >= kMaxResends) return;
  ++camera_.counts().resend_requests;
  resends_.push_back(*request);
}

GigeDevice::Acknowledgement GigeDevice::act(const GvcpCommand& command, Timestamp received) {
  const auto action = parse_action(command);
  if (!action) return gvcp_acknowledge(command, GvcpStatus::invalid_parameter);
  if (!camera_.is_meant_by(*action)) return std::nullopt;
  return gvcp_acknowledge(command, camera_.carry_out(*action, received));
}

// --- access -----------------------------------------------------------------------------------------------------

bool GigeDevice::may_read(Endpoint from) const {
  const bool exclusive = (camera_.registers().get(reg::kControlPrivilege) & kExclusive) != 0;
  return !exclusive || controller_ == from;
}

GvcpStatus GigeDevice::denied() {
  ++camera_.counts().denied;
  return GvcpStatus::access_denied;
}

GvcpStatus GigeDevice::write_word(std::uint32_t address, std::uint32_t value, Endpoint from, Timestamp received) {
  if (address % 4 != 0) return GvcpStatus::bad_alignment;
  if (address == reg::kControlPrivilege) return change_privilege(value, from, received);
  if (controller_ != from) return denied();
  const auto status = camera_.write(address, value, received);
  if (address == reg::kSwitchoverKey && status == GvcpStatus::success) {
    switchover_key_ = value;
    camera_.registers().set(reg::kSwitchoverKey, 0);
  }
  return status;
}

GvcpStatus GigeDevice::change_privilege(std::uint32_t value, Endpoint from, Timestamp received) {
  if (controller_ && controller_ != from && !may_take_over(value)) return denied();
  if ((value & 0xFFFF & ~kPrivileges) != 0) return GvcpStatus::invalid_parameter;
  if ((value & kPrivileges) == 0) {
    release_control(received);
    return GvcpStatus::success;
  }
  give_control(from, value & kPrivileges);
  last_heard_ = received;
  return GvcpStatus::success;
}

bool GigeDevice::may_take_over(std::uint32_t value) const {
  const std::uint32_t now = camera_.registers().get(reg::kControlPrivilege);
  const bool enabled = (now & kSwitchover) != 0 && (now & kExclusive) == 0;
  return enabled && (value & kPrivileges) != 0 && value >> 16 == switchover_key_;
}

void GigeDevice::give_control(Endpoint to, std::uint32_t privilege) {
  controller_ = to;
  auto& registers = camera_.registers();
  registers.set(reg::kControlPrivilege, privilege);
  registers.set(reg::kPrimaryPort, to.port);
  registers.set(reg::kPrimaryAddress, to.address);
}

void GigeDevice::release_control(Timestamp at) {
  camera_.stop_acquisition(at);
  camera_.forget_test_packets();
  give_control({}, 0);
  controller_.reset();
  last_write_ = {};
  switchover_key_ = 0;
  resends_.clear();
  late_.clear();
  camera_.registers().set(reg::kHostPort, 0);
}

void GigeDevice::check_heartbeat(Timestamp now) {
  const auto& registers = camera_.registers();
  if ((registers.get(reg::kGvcpConfiguration) & kHeartbeatDisable) != 0) return;
  const auto timeout = std::chrono::milliseconds{registers.get(reg::kHeartbeatMs)};
  if (!controller_ || controller_ == kThief || now - last_heard_ < timeout) return;
  ++camera_.counts().lost_controllers;
  release_control(now);
}

// --- errands ----------------------------------------------------------------------------------------------------

void GigeDevice::line0_edge(Timestamp at) {
  camera_.set_line0(true, at);
  camera_.set_line0(false, at + kPulse);
}

std::optional<DueFrame> GigeDevice::take_due(Timestamp now) {
  advance(now);
  return camera_.take_due(now);
}

std::optional<ResendCommand> GigeDevice::take_resend() {
  if (resends_.empty()) return std::nullopt;
  const auto request = resends_.front();
  resends_.pop_front();
  return request;
}

// --- faults -----------------------------------------------------------------------------------------------------

void GigeDevice::advance(Timestamp now) {
  auto& counts = camera_.counts().faults;
  for (const auto& edge : faults().take_edges(now)) {
    if (edge.kind == FaultKind::reboot && edge.begins) reboot(edge.at);
    if (edge.kind == FaultKind::control_stolen && edge.begins) steal_control(edge.at);
    counts[FaultKind::over_temperature] += edge.kind == FaultKind::over_temperature && edge.begins;
    counts[FaultKind::clock_step] += edge.kind == FaultKind::clock_step && edge.begins;
  }
  if (controller_ == kThief && !faults().in_force(now).control_stolen) release_control(now);
  camera_.advance(now);
}

GigeDevice::Acknowledgement GigeDevice::slowed(const GvcpCommand& command, std::vector<std::uint8_t> acknowledgement,
                                               Endpoint to, Timestamp received, nanoseconds by) {
  ++camera_.counts().faults[FaultKind::slow_registers];
  acknowledge_late({received + by, std::move(acknowledgement), to});
  return pending(command, by);
}

void GigeDevice::reboot(Timestamp at) {
  ++camera_.counts().faults[FaultKind::reboot];
  release_control(at);
  camera_.power_cycle(at);
}

// As when the controller's heartbeat was held up and somebody else was quicker.
void GigeDevice::steal_control(Timestamp at) {
  ++camera_.counts().faults[FaultKind::control_stolen];
  release_control(at);
  const auto theft = faults().in_force(at).control_stolen;
  give_control(kThief, theft && !theft->exclusive ? kControl : kExclusive);
}

}  // namespace rotunda::simulator
