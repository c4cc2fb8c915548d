#pragma once
// One simulated camera's control channel: who controls it, and what each datagram is answered. No sockets, no threads,
// no clock of its own: datagrams and times come in, acknowledgements and due frames go out. What the registers do is
// SimulatedCamera's part.
//   Control: one client holds the privilege (register 0xA00) until it gives it back or its heartbeat stops; nobody
//   else may write (0x8006), or read if it is exclusive. With switchover enabled, whoever knows its key takes over and
//   the stream goes on.
//   What takes the camera long (flash memory) is answered by PENDING_ACK at once and acknowledged when it is done.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "simulator/gige/simulated_camera.h"

namespace rotunda::simulator {

struct LateAcknowledgement {
  capture::Timestamp when;
  std::vector<std::uint8_t> datagram;
  Endpoint to;
};

class GigeDevice {
 public:
  // Throws InvalidInput as DeviceRegisters does. `role`: what this camera's clock becomes when PTP is on. It has had
  // power since `powered_up`.
  GigeDevice(const GigeCameraOptions& options, PtpStatus role, std::uint16_t stream_source_port,
             capture::Timestamp powered_up = {});

  // The acknowledgement to send back, if any. Any bytes are welcome.
  std::optional<std::vector<std::uint8_t>> handle(std::span<const std::uint8_t> datagram, Endpoint from,
                                                  capture::Timestamp received);
  std::optional<capture::Timestamp> next_late_acknowledgement() const;
  std::optional<LateAcknowledgement> take_late_acknowledgement(capture::Timestamp now);

  void set_line0(bool high, capture::Timestamp at) { camera_.set_line0(high, at); }
  void line0_edge(capture::Timestamp at);  // a pulse
  // Frees the control of a client not heard for its heartbeat timeout. Call once all that was received is handled.
  void check_heartbeat(capture::Timestamp now);
  // Lets the faults begin and end whose time has come. handle() and take_due() do so too.
  void advance(capture::Timestamp now);

  std::optional<capture::Timestamp> next_due() const { return camera_.next_due(); }
  std::optional<DueFrame> take_due(capture::Timestamp now);
  std::optional<ResendCommand> take_resend();
  std::optional<TestPacket> take_test_packet() { return camera_.take_test_packet(); }
  bool has_errand() const { return !resends_.empty() || camera_.has_test_packet(); }

  bool has_controller() const { return controller_.has_value(); }
  bool is_acquiring() const { return camera_.is_acquiring(); }
  const DeviceCounts& counts() const { return camera_.counts(); }
  FaultSchedule& faults() { return camera_.faults(); }
  const FaultSchedule& faults() const { return camera_.faults(); }

 private:
  using Acknowledgement = std::optional<std::vector<std::uint8_t>>;
  Acknowledgement answer(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement answer_write(const GvcpCommand& command, std::span<const std::uint8_t> datagram, Endpoint from,
                               capture::Timestamp received);
  Acknowledgement read_registers(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement read_memory(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement write_registers(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement write_memory(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement force_ip(const GvcpCommand& command) const;
  Acknowledgement act(const GvcpCommand& command, capture::Timestamp received);
  void note_resend(const GvcpCommand& command);

  bool may_read(Endpoint from) const;
  GvcpStatus write_word(std::uint32_t address, std::uint32_t value, Endpoint from, capture::Timestamp received);
  GvcpStatus change_privilege(std::uint32_t value, Endpoint from, capture::Timestamp received);
  bool may_take_over(std::uint32_t value) const;
  void give_control(Endpoint to, std::uint32_t privilege);
  void release_control(capture::Timestamp at);
  GvcpStatus denied();

  Acknowledgement slowed(const GvcpCommand& command, std::vector<std::uint8_t> acknowledgement, Endpoint to,
                         capture::Timestamp received, std::chrono::nanoseconds by);
  Acknowledgement pending(const GvcpCommand& command, std::chrono::nanoseconds effort);
  void acknowledge_late(LateAcknowledgement acknowledgement);
  void reboot(capture::Timestamp at);
  void steal_control(capture::Timestamp at);

  SimulatedCamera camera_;
  std::optional<Endpoint> controller_;
  capture::Timestamp last_heard_;
  std::uint32_t switchover_key_ = 0;  // write-only, so not in the registers
  std::deque<ResendCommand> resends_;
  std::deque<LateAcknowledgement> late_;  // in order of time
  struct LastWrite {
    Endpoint from;
    std::vector<std::uint8_t> command;
    Acknowledgement first, last;  // the same, unless it is pending until `done`
    capture::Timestamp done;
  } last_write_;  // a client that missed the acknowledgement repeats itself; it must not trigger twice
};

}  // namespace rotunda::simulator
