#pragma once
// What stands behind a camera's control channel: what its registers do. Its clock, its triggers and exposures, its
// line, its temperature, its user sets. No sockets, no threads, no clock of its own: values and times come in, due
// frames go out. GigeDevice says who may talk to it.
//   Time: a frame's exposure starts exactly when its trigger says: when the camera's clock shows the scheduled time of
//   an ACTION_CMD, otherwise the moment the kernel received the datagram (software trigger, immediate action), an edge
//   of Line0, the frame-rate grid in free run.
//   A scheduled action that arrives after its time is acknowledged with 0x8016 and carried out at once, as Basler's
//   cameras do; its exposure starts when it was received. Without PTP's time it is refused with 0x8013.
//   Clock: what the camera stamps, latches and schedules by is its CameraClock plus what its faults make of it.
//   Faults: those that concern the camera itself happen here, by its FaultSchedule; each frame takes along the rest.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "simulator/gige/acquisition.h"
#include "simulator/gige/camera_clock.h"
#include "simulator/gige/camera_options.h"
#include "simulator/gige/device_counts.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/fault_schedule.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/line_input.h"
#include "simulator/gige/thermometer.h"
#include "simulator/gige/udp_socket.h"
#include "simulator/gige/user_sets.h"

namespace rotunda::simulator {

// A frame whose exposure and readout are over.
struct DueFrame {
  std::uint64_t block = 0;
  bool extended_ids = false;
  capture::Timestamp exposure_start, due;  // true time
  std::chrono::nanoseconds exposure{};     // how long the shutter stays open
  capture::Timestamp stamp;                // exposure_start by the camera's clock
  Endpoint destination;                    // port 0: nobody asked for the stream
  std::uint32_t packet_size = 0, pixel_code = 0, width = 0, height = 0, offset_x = 0, offset_y = 0;
  std::chrono::nanoseconds packet_delay{}, transmission_delay{};
  std::vector<std::uint8_t> chunks;             // to follow the pixels
  std::optional<ImageSettings> image_settings;  // nothing: as the camera was made
  GigeFaults faults;                            // in force when its exposure started
};

struct TestPacket {
  Endpoint destination;
  std::size_t bytes = 0;  // UDP payload
};

class SimulatedCamera {
 public:
  // Throws InvalidInput as DeviceRegisters does. `role`: what this camera's clock becomes when PTP is on.
  SimulatedCamera(const GigeCameraOptions& options, PtpStatus role, std::uint16_t stream_source_port,
                  capture::Timestamp powered_up);
  void power_cycle(capture::Timestamp at);  // all is as at power-up, but for what UserSets keeps

  // What a client reads and writes, once it may. Reads give nothing where there is no memory.
  std::optional<std::vector<std::uint8_t>> read(std::uint32_t address, std::size_t bytes, capture::Timestamp at);
  GvcpStatus write(std::uint32_t address, std::uint32_t value, capture::Timestamp at);
  // How long what was written since the last call takes the camera: flash memory is slow.
  std::chrono::nanoseconds take_effort();

  bool is_meant_by(const ActionCommand& action) const;
  GvcpStatus carry_out(const ActionCommand& action, capture::Timestamp received);
  void set_line0(bool high, capture::Timestamp at);
  void stop_acquisition(capture::Timestamp at);

  // Takes in what has happened up to `now` on the line. take_due() does so too.
  void advance(capture::Timestamp now);
  std::optional<capture::Timestamp> next_due() const;
  std::optional<DueFrame> take_due(capture::Timestamp now);
  std::optional<TestPacket> take_test_packet();
  bool has_test_packet() const { return !test_packets_.empty(); }
  void forget_test_packets() { test_packets_.clear(); }

  bool is_acquiring() const { return acquisition_.is_running(); }
  DeviceRegisters& registers() { return registers_; }
  const DeviceRegisters& registers() const { return registers_; }
  FaultSchedule& faults() { return faults_; }
  const FaultSchedule& faults() const { return faults_; }
  DeviceCounts& counts() { return counts_; }
  const DeviceCounts& counts() const { return counts_; }

 private:
  GvcpStatus react(std::uint32_t address, std::uint32_t value, capture::Timestamp at);
  void latch_timestamp(capture::Timestamp at);
  void latch_ptp(capture::Timestamp at);
  void set_ptp(bool enabled, capture::Timestamp at);
  void fire_test_packet(std::uint32_t value);
  GvcpStatus save_user_set();
  GvcpStatus load_user_set(capture::Timestamp at);
  void start_acquisition(capture::Timestamp at);

  void refresh(capture::Timestamp at);  // what changes by itself
  void falsify(std::uint32_t address, std::span<std::uint8_t> memory, capture::Timestamp at);
  double temperature(capture::Timestamp at) const;
  bool withholds(const DueFrame& frame);

  capture::Timestamp camera_time(capture::Timestamp at) const;
  GvcpStatus trigger(TriggerSource source, capture::Timestamp at);
  AcquisitionSettings acquisition_settings() const;
  std::chrono::nanoseconds debounce() const;
  DueFrame frame_of(const StartedExposure& exposure, const AcquisitionSettings& settings);
  std::vector<std::uint8_t> chunks_of(const DueFrame& frame) const;
  Endpoint stream_destination() const;

  GigeCameraOptions options_;
  PtpStatus role_;
  std::uint16_t stream_source_port_;
  DeviceRegisters factory_, registers_;
  UserSets user_sets_;
  CameraClock clock_;
  Thermometer thermometer_;
  LineInput line_;
  Acquisition acquisition_;
  FaultSchedule faults_;
  std::deque<TestPacket> test_packets_;
  std::chrono::nanoseconds effort_{};
  DeviceCounts counts_;
};

}  // namespace rotunda::simulator
