#include "rig/daemon/live_mocap.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "rig/daemon/low_priority.h"

namespace rotunda::rig {

LiveMocap::LiveMocap() : thread_([this](const std::stop_token& stop) { work_off(stop); }) {}

LiveMocap::~LiveMocap() {
  queue_.close();
  thread_ = {};
}

void LiveMocap::offer(const capture::FrameSet& set, const Cameras& cameras, const std::vector<recon::LiveView>& views) {
  {
    const std::lock_guard lock(mutex_);
    if (watchers_ == 0 || set.time <= offered_) return;
    offered_ = set.time;
    fed_ = std::chrono::steady_clock::now();
  }
  queue_.push_drop_oldest({set.trigger, set.time, cameras, views});
}

bool LiveMocap::is_watched() const {
  const std::lock_guard lock(mutex_);
  return watchers_ > 0;
}

bool LiveMocap::is_fed() const {
  constexpr std::chrono::seconds kLately{2};
  const std::lock_guard lock(mutex_);
  return std::chrono::steady_clock::now() - fed_ < kLately;
}

void LiveMocap::work_off(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "mocap");
  lower_priority();
  tbb::task_arena arena;
  const LowPriority low(arena);
  recon::LiveMotion motion;
  Cameras cameras;
  capture::Timestamp last{};
  while (const auto job = queue_.pop(stop)) {
    if (job->cameras != cameras) motion = {};
    cameras = job->cameras;
    const double seconds = std::chrono::duration<double>(job->exposure - std::exchange(last, job->exposure)).count();
    try {
      arena.execute([&] { publish(*job, motion.follow(recon::live_outlines(job->views, *cameras), seconds)); });
    } catch (const std::exception& error) {
      spdlog::warn("live motion capture: {}", error.what());
      motion = {};
    }
  }
}

void LiveMocap::publish(const Job& job, recon::LiveMotionFrame&& motion) {
  auto frame = std::make_shared<const MotionFrame>(
      MotionFrame{job.trigger, job.exposure, capture::RigClock::now(), std::move(motion)});
  const std::lock_guard lock(mutex_);
  newest_ = std::move(frame);
  ++sequence_;
  changed_.notify_all();
}

MotionWatcher::MotionWatcher(LiveMocap& mocap) : mocap_(mocap) {
  const std::lock_guard lock(mocap_.mutex_);
  seen_ = mocap_.sequence_;  // what is left of an earlier watcher is not live
  ++mocap_.watchers_;
}

MotionWatcher::~MotionWatcher() {
  const std::lock_guard lock(mocap_.mutex_);
  --mocap_.watchers_;
}

std::shared_ptr<const MotionFrame> MotionWatcher::next(std::chrono::milliseconds patience) {
  std::unique_lock lock(mocap_.mutex_);
  if (!mocap_.changed_.wait_for(lock, patience, [&] { return mocap_.sequence_ != seen_; })) return nullptr;
  seen_ = mocap_.sequence_;
  return mocap_.newest_;
}

}  // namespace rotunda::rig
