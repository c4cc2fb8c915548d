#pragma once
// One camera's clock, watched: an IEEE 1588 (PTP) port where it has one, by its names in GenICam SFNC 2.x and by those
// used before; else a clock of its own, modelled from time stamp latches. What comes out is a map from the camera's
// time stamps to the rig's time, and what is wrong.
// A PTP clock is believed if it agrees with this machine's; one that is off by TAI less UTC to the second counts the
// other of the two and is moved; any other is modelled like a clock of the camera's own.
// Talks to the camera: calls block, and throw DeviceError. No thread, no clock but the one it is given.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/source/feature_access.h"
#include "capture/sync/clock_model.h"

namespace rotunda::capture {

// Since 2017-01-01 (IERS Bulletin C 52). Cameras and masters that do not know it stay on UTC.
inline constexpr std::chrono::seconds kTaiLessUtc{37};

struct ClockWatchOptions {
  bool use_ptp = true;
  std::chrono::nanoseconds ptp_offset_limit{std::chrono::microseconds(100)};  // of a Slave from its master
};

struct ClockState {
  std::string kind;  // "ptp slave", "ptp listening", ...: its port's state; "model"; "none"; empty: not looked at yet
  std::optional<std::chrono::nanoseconds> offset;  // from its PTP master; of a model: the last reading from the line
  std::optional<std::chrono::nanoseconds> error;   // how wrong a time stamp may be, on top of the offset
  std::chrono::seconds moved{};                    // added to its time stamps because it counts UTC (or we do)
  bool settled = false;                            // nothing to wait for: Slave within its limit, Master, or no PTP
  std::string identity, parent, grandmaster;       // PTP clock identities where the camera tells
  std::string problem;                             // what is wrong and what to do; empty: nothing
};

class ClockWatch {
 public:
  using Now = std::function<Timestamp()>;

  // The camera must outlive it.
  explicit ClockWatch(FeatureAccess& camera, const ClockWatchOptions& options = {}, Now now = RigClock::now);

  // Switches PTP on where the camera has it, and reads its clock a first few times.
  void begin();
  // Asks the camera; now and then, a second apart is often enough.
  ClockState look();
  // From the camera's time stamps to the rig's time, as of the last look.
  const ClockMap& map() const { return map_; }

 private:
  struct Names {  // empty: the camera has none
    std::string enable, status, latch, offset, identity, parent, grandmaster;
    std::string time_latch, time_value, tick_frequency;
  };
  static Names names_in(FeatureAccess& camera, bool use_ptp);
  std::optional<ClockReading> read_clock();
  void look_at_ptp(ClockState& state);
  void look_at_own_clock(ClockState& state, const std::optional<ClockReading>& reading);
  void compare_with_rig(ClockState& state, const ClockReading& reading);

  FeatureAccess& camera_;
  ClockWatchOptions options_;
  Now now_;
  Names names_;
  double ns_a_tick_ = 1.0;
  ClockModel model_;
  ClockMap map_;
};

// What is wrong with the cameras' clocks taken together: there must be one PTP master, followed by all.
struct NamedClock {
  CameraId camera;
  ClockState clock;
};
std::vector<std::string> ptp_domain_problems(const std::vector<NamedClock>& cameras);

// For a clock nobody can ask: what to add to its time stamps, told from a frame's stamp and when it came. Nothing for
// half a second between them, TAI less UTC if that explains it, else all of it.
std::chrono::nanoseconds guessed_clock_shift(Timestamp stamp, Timestamp came);

}  // namespace rotunda::capture
