#include "capture/sync/trigger.h"

#include <pthread.h>

#include <condition_variable>
#include <utility>

#include "capture/base/timely_thread.h"
#include "config/errors.h"

namespace rotunda::capture {

namespace {

TriggerScheduleOptions starting_soon(double rate_hz, std::optional<std::uint64_t> count, Timestamp now,
                                     int lead_periods) {
  const auto period = period_of(rate_hz);
  return {grid_from(now + period * (lead_periods + 1), period), count, period * lead_periods};
}

// False when asked to stop. Looks at the rig's clock again after every wait, as that may be stepped.
bool sleep_until(Timestamp moment, std::stop_token stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  for (auto left = moment - RigClock::now(); left.count() > 0 && !stop.stop_requested();
       left = moment - RigClock::now())
    never.wait_for(lock, stop, std::min<std::chrono::nanoseconds>(left, std::chrono::seconds(1)), [] { return false; });
  return !stop.stop_requested();
}

}  // namespace

TriggerScheduleOptions scheduled_triggers(double rate_hz, std::optional<std::uint64_t> count, Timestamp now) {
  return starting_soon(rate_hz, count, now, 2);
}

TriggerScheduleOptions immediate_triggers(double rate_hz, std::optional<std::uint64_t> count, Timestamp now) {
  return starting_soon(rate_hz, count, now, 0);
}

TriggerSchedule::TriggerSchedule(const TriggerScheduleOptions& options, Fire fire)
    : options_(options), fire_(std::move(fire)) {
  if (options_.grid.period.count() <= 0) throw InvalidInput("triggers need a period longer than nothing");
  thread_ = std::jthread([this](std::stop_token stop) { run(std::move(stop)); });
}

TriggerSchedule::~TriggerSchedule() {
  stop();
}

void TriggerSchedule::stop() {
  thread_.request_stop();
  wait();
}

void TriggerSchedule::wait() {
  if (thread_.joinable()) thread_.join();
}

TriggerCounts TriggerSchedule::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void TriggerSchedule::rethrow_failure() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void TriggerSchedule::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "trigger");
  make_this_thread_timely();
  for (std::uint64_t k = 0; !options_.count || k < *options_.count; ++k) {
    const Trigger trigger{k, options_.grid.time_of(k)};
    if (!sleep_until(trigger.at - options_.lead, stop) || !fire_one(trigger)) break;
  }
  const std::lock_guard lock(mutex_);
  counts_.finished = true;
}

bool TriggerSchedule::fire_one(const Trigger& trigger) {
  const auto left = trigger.at - RigClock::now();  // to its moment; negative once past
  const bool immediate = options_.lead.count() == 0;
  const bool skip = left < (immediate ? -options_.grid.period / 2 : std::chrono::nanoseconds(0));
  const bool late = left < (immediate ? -options_.grid.period / 4 : options_.lead / 2);
  try {
    if (!skip) fire_(trigger);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (skip) {
    ++counts_.skipped;
  } else {
    ++counts_.fired;
    if (late) ++counts_.late;
  }
  return true;
}

}  // namespace rotunda::capture
