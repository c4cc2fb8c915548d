#pragma once
// When a camera exposes: its triggers and its free run, and the number each frame gets. Pure: all times are true time.
//   An exposure starts when its trigger says, a TriggerDelay later; free run keeps its grid however late anyone looks.
//   A trigger during another exposure is ignored, as is one heard twice.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "simulator/gige/device_counts.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/fault_schedule.h"
#include "simulator/gige/gvcp.h"

namespace rotunda::simulator {

inline constexpr std::chrono::nanoseconds kReadout = std::chrono::microseconds{500};  // exposure's end to first packet

struct AcquisitionSettings {
  AcquisitionMode mode{};
  std::uint32_t frame_count = 1;  // of a multi-frame acquisition
  bool triggered = false;
  TriggerSource source{};
  std::chrono::nanoseconds trigger_delay{}, exposure{};
  std::chrono::nanoseconds period{};  // of the free run
  bool extended_ids = false;

  std::chrono::nanoseconds busy_time() const { return exposure + kReadout; }
};

struct StartedExposure {
  capture::Timestamp start;
  std::uint64_t block = 0;
};

class Acquisition {
 public:
  void start(const AcquisitionSettings& settings, capture::Timestamp at);
  void stop();
  void change_trigger_mode(bool triggered, capture::Timestamp at);
  bool is_running() const { return running_; }
  bool expects_frame() const { return next_free_run_.has_value() || !pending_.empty(); }

  GvcpStatus trigger(const AcquisitionSettings& settings, TriggerSource source, capture::Timestamp at,
                     FaultSchedule& faults, DeviceCounts& counts);
  // When the next frame is exposed and read out.
  std::optional<capture::Timestamp> next_due(const AcquisitionSettings& settings) const;
  std::optional<StartedExposure> take_due(const AcquisitionSettings& settings, capture::Timestamp now,
                                          FaultSchedule& faults);

 private:
  void expose(capture::Timestamp start);
  bool was_heard(capture::Timestamp at) const;
  bool overlaps_another(const AcquisitionSettings& settings, capture::Timestamp start) const;
  void skip_missed_free_run(const AcquisitionSettings& settings, capture::Timestamp now);
  std::uint64_t next_block(bool extended_ids);

  bool running_ = false;
  std::uint64_t last_block_ = 0;
  std::optional<std::uint32_t> frames_left_;         // of a single- or multi-frame acquisition
  std::optional<capture::Timestamp> next_free_run_;  // while free running
  std::optional<capture::Timestamp> last_start_;
  std::deque<capture::Timestamp> pending_;  // triggered exposures, ascending
  std::deque<capture::Timestamp> heard_;    // the last triggers, whatever became of them
};

}  // namespace rotunda::simulator
