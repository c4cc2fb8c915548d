#pragma once
// A camera's clock: its crystal, and the IEEE 1588 port that may discipline it. Pure: the rig's true time goes in, what
// the camera reads comes out, both in nanoseconds.
//   Free running it counts from 0 at power-up (or its last reset) and gains drift_ppm.
//   With PTP on it goes Initializing, Listening, then Uncalibrated while its servo closes what is left of the offset
//   (exponentially, as a PI controller does once the clock was stepped), and Slave below 1 us; a Slave wanders about
//   its master by `wander`. The rig's true time is the time of the domain's master: a Master shows it exactly. Switched
//   off again, it goes on from where it is, at its crystal's rate.
#include <chrono>
#include <cstdint>
#include <optional>

#include "capture/frame.h"

namespace rotunda::simulator {

// IEEE 1588-2008, table 8, portState: those a camera's port can be in.
enum class PtpStatus : std::uint32_t {
  initializing = 1,
  disabled = 3,
  listening = 4,
  master = 6,
  uncalibrated = 8,
  slave = 9
};

struct CameraClockOptions {
  bool ptp = true;                    // PtpEnable at power-up
  double drift_ppm = 0.0;             // of the crystal, free running
  std::chrono::nanoseconds wander{};  // a Slave's offset stays within
  std::uint64_t seed = 1;             // of the wandering
};

// What crystals and servos of machine vision cameras do, different for every seed: within +-25 ppm and +-120 ns.
CameraClockOptions realistic_clock(std::uint64_t seed);

class CameraClock {
 public:
  // `role`: master or slave, what the port becomes when PTP is on.
  CameraClock(const CameraClockOptions& options, PtpStatus role, capture::Timestamp powered_up);

  void enable_ptp(capture::Timestamp now);  // again: no effect
  void disable_ptp(capture::Timestamp now);
  void reset(capture::Timestamp now);  // to 0; without effect while PTP is on

  PtpStatus status(capture::Timestamp now) const;
  bool is_synchronised(capture::Timestamp now) const;                         // Slave or Master: knows the rig's time
  std::chrono::nanoseconds offset_from_master(capture::Timestamp now) const;  // 0 unless Uncalibrated or Slave

  capture::Timestamp reading(capture::Timestamp true_time) const;
  // The true time at which it reads that, if nothing switches PTP until then.
  capture::Timestamp true_time(capture::Timestamp reading) const;
  // How long the camera's crystal takes for what it counts as `counted`.
  std::chrono::nanoseconds true_duration(std::chrono::nanoseconds counted) const;

 private:
  std::optional<capture::Timestamp> disciplined_since() const;
  std::chrono::nanoseconds servo_error(capture::Timestamp now) const;
  std::chrono::nanoseconds wander_at(capture::Timestamp now) const;
  capture::Timestamp free_reading(capture::Timestamp true_time) const;

  CameraClockOptions options_;
  PtpStatus role_;
  capture::Timestamp anchor_, anchor_reading_;  // free running: it read that then
  std::optional<capture::Timestamp> ptp_since_;
};

}  // namespace rotunda::simulator
