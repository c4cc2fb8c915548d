#pragma once
// For work beside a recording: whoever receives or records frames comes first.
#include <sys/resource.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>
#include <unistd.h>

namespace rotunda::rig {

// Of the calling thread, for good.
inline void lower_priority() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

// oneTBB's threads that come to help in the arena stay at that for good: nothing else in the daemon uses them.
class LowPriority : public tbb::task_scheduler_observer {
 public:
  explicit LowPriority(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
  ~LowPriority() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) lower_priority();
  }
};

}  // namespace rotunda::rig
