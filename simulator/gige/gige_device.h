#pragma once
// One simulated camera's state machine: who controls it, whether it acquires, what it was triggered for. No sockets,
// no threads, no clock of its own: datagrams and times come in, acknowledgements and due frames go out.
//   Control: one client holds the privilege (register 0xA00) until it gives it back or its heartbeat stops; nobody
//   else may write (0x8006).
//   Time: a frame's exposure starts exactly when its trigger says: the scheduled time of an ACTION_CMD, otherwise the
//   moment the kernel received the datagram (software trigger, immediate action), the frame-rate grid in free run.
//   A scheduled action that arrives after its time is acknowledged with 0x8016 and carried out at once, as Basler's
//   cameras do; its exposure starts when it was received.
//   Clock: what the camera stamps, latches and schedules by is true time plus what its faults make of it.
//   Faults: those that concern the camera itself happen here, by its FaultSchedule; each frame takes along the rest.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "simulator/gige/camera_options.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/fault_schedule.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::simulator {

// A frame whose exposure and readout are over.
struct DueFrame {
  std::uint16_t block = 0;
  capture::Timestamp exposure_start, due;
  std::chrono::nanoseconds exposure{};  // how long the shutter stays open
  capture::Timestamp stamp;             // exposure_start by the camera's clock
  Endpoint destination;                 // port 0: nobody asked for the stream
  std::uint32_t packet_size = 0, pixel_code = 0, width = 0, height = 0;
  std::chrono::nanoseconds packet_delay{};
  GigeFaults faults;  // in force when its exposure started
};

struct TestPacket {
  Endpoint destination;
  std::size_t bytes = 0;  // UDP payload
};

struct DeviceCounts {
  std::uint64_t triggers = 0;          // accepted, of any kind; free run does not count
  std::uint64_t ignored_triggers = 0;  // not armed, or during an exposure
  std::uint64_t late_actions = 0;
  std::uint64_t resend_requests = 0;
  std::uint64_t denied = 0;            // commands refused with 0x8006
  std::uint64_t lost_controllers = 0;  // heartbeats that stopped
  FaultCounts faults;
};

class GigeDevice {
 public:
  // Throws InvalidInput as DeviceRegisters does. `ptp`: the role this camera's clock reports when PtpEnable is on.
  GigeDevice(const GigeCameraOptions& options, PtpStatus ptp, std::uint16_t stream_source_port);

  // The acknowledgement to send back, if any. Any bytes are welcome.
  std::optional<std::vector<std::uint8_t>> handle(std::span<const std::uint8_t> datagram, Endpoint from,
                                                  capture::Timestamp received);
  void line0_edge(capture::Timestamp at);
  // Frees the control of a client not heard for its heartbeat timeout. Call once all that was received is handled.
  void check_heartbeat(capture::Timestamp now);
  // Lets the faults begin and end whose time has come. handle() and take_due() do so too.
  void advance(capture::Timestamp now);

  std::optional<capture::Timestamp> next_due() const;
  std::optional<DueFrame> take_due(capture::Timestamp now);
  std::optional<ResendCommand> take_resend();
  std::optional<TestPacket> take_test_packet();
  bool has_errand() const { return !resends_.empty() || !test_packets_.empty(); }

  bool has_controller() const { return controller_.has_value(); }
  bool is_acquiring() const { return acquiring_; }
  const DeviceCounts& counts() const { return counts_; }
  FaultSchedule& faults() { return faults_; }
  const FaultSchedule& faults() const { return faults_; }

 private:
  using Acknowledgement = std::optional<std::vector<std::uint8_t>>;
  Acknowledgement answer(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement read_registers(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement read_memory(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement write_registers(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement write_memory(const GvcpCommand& command, Endpoint from, capture::Timestamp received);
  Acknowledgement force_ip(const GvcpCommand& command) const;
  Acknowledgement act(const GvcpCommand& command, capture::Timestamp received);
  void note_resend(const GvcpCommand& command);

  void power_up();
  void reboot();
  void steal_control(capture::Timestamp at);
  void return_control();
  void falsify(std::uint32_t address, std::span<std::uint8_t> memory, capture::Timestamp at);
  std::uint32_t temperature(capture::Timestamp at) const;
  bool withholds(const DueFrame& frame);
  capture::Timestamp camera_time(capture::Timestamp at) const { return at + faults_.clock_error(at); }

  bool may_read(Endpoint from) const;
  GvcpStatus write_word(std::uint32_t address, std::uint32_t value, Endpoint from, capture::Timestamp received);
  GvcpStatus change_privilege(std::uint32_t value, Endpoint from, capture::Timestamp received);
  void release_control();
  void react(std::uint32_t address, std::uint32_t value, capture::Timestamp received);
  void fire_test_packet(std::uint32_t value);
  void start_acquisition(capture::Timestamp at);
  void stop_acquisition();

  GvcpStatus carry_out(const ActionCommand& action, capture::Timestamp received);
  GvcpStatus trigger(TriggerSource source, capture::Timestamp at);
  void expose(capture::Timestamp start);
  bool was_heard(capture::Timestamp at) const;
  bool is_armed_for(TriggerSource source) const;
  bool overlaps_another(capture::Timestamp start) const;
  void skip_missed_free_run(capture::Timestamp now);
  DueFrame frame_at(capture::Timestamp start);
  std::optional<DueFrame> next_frame(capture::Timestamp now);
  std::chrono::nanoseconds exposure() const;
  std::chrono::nanoseconds busy_time() const;  // exposure and readout
  std::chrono::nanoseconds free_run_period() const;
  Endpoint stream_destination() const;

  GigeCameraOptions options_;
  PtpStatus ptp_;
  std::uint16_t stream_source_port_;
  DeviceRegisters registers_;
  FaultSchedule faults_;
  std::optional<Endpoint> controller_;
  capture::Timestamp last_heard_;
  bool acquiring_ = false;
  std::uint16_t last_block_ = 0;
  std::optional<std::uint32_t> frames_left_;         // of a single- or multi-frame acquisition
  std::optional<capture::Timestamp> next_free_run_;  // while free running
  std::optional<capture::Timestamp> last_start_;
  std::deque<capture::Timestamp> pending_;  // triggered exposures, ascending
  std::deque<capture::Timestamp> heard_;    // the last triggers, whatever became of them
  std::deque<ResendCommand> resends_;
  std::deque<TestPacket> test_packets_;
  struct {
    Endpoint from;
    std::vector<std::uint8_t> command, acknowledgement;
  } last_write_;  // a client that missed the acknowledgement repeats itself; it must not trigger twice
  DeviceCounts counts_;
};

}  // namespace rotunda::simulator
