#pragma once
// Fires a take's triggers, one thread for all: trigger k belongs to the moment grid.time_of(k) on the rig's clock.
// Scheduled (action commands): handed out `lead` ahead of its moment. Immediate (software triggers): at its moment.
// A trigger that cannot be handed out in time any more is skipped and counted, never sent late onto another's place.
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/sync/trigger_grid.h"

namespace rotunda::capture {

struct Trigger {
  std::uint64_t number = 0;
  Timestamp at;
};

struct TriggerScheduleOptions {
  TriggerGrid grid;
  std::optional<std::uint64_t> count;  // exactly so many; nothing: until stopped
  std::chrono::nanoseconds lead{};     // 0: immediate
};

struct TriggerCounts {
  std::uint64_t fired = 0;
  std::uint64_t late = 0;  // of these, handed out with less than half the lead left (immediate: a quarter period late)
  std::uint64_t skipped = 0;  // its moment had passed (immediate: by half a period)
  bool finished = false;      // the count is reached, stopped, or firing failed
};

// Options for a take that starts soon: the first trigger is the first multiple of the period after `now` that leaves
// the lead of two periods, plus one period to get going.
TriggerScheduleOptions scheduled_triggers(double rate_hz, std::optional<std::uint64_t> count, Timestamp now);
TriggerScheduleOptions immediate_triggers(double rate_hz, std::optional<std::uint64_t> count, Timestamp now);

class TriggerSchedule {
 public:
  // Called on the schedule's thread, in order; must return well within a period. What it throws ends the schedule and
  // is kept for rethrow_failure().
  using Fire = std::function<void(const Trigger&)>;

  TriggerSchedule(const TriggerScheduleOptions& options, Fire fire);  // throws InvalidInput without a period
  ~TriggerSchedule();                                                 // stops

  void stop();  // no trigger is handed out after it returns
  void wait();  // until the count is reached or firing failed
  TriggerCounts counts() const;
  void rethrow_failure() const;  // does nothing while all went well
  const TriggerScheduleOptions& options() const { return options_; }

 private:
  void run(std::stop_token stop);
  bool fire_one(const Trigger& trigger);

  TriggerScheduleOptions options_;
  Fire fire_;
  mutable std::mutex mutex_;
  TriggerCounts counts_;
  std::exception_ptr failure_;
  std::jthread thread_;  // last: starts when everything else is there
};

}  // namespace rotunda::capture
