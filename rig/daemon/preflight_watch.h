#pragma once
// The daemon's own preflight: looks at the machine every two seconds, in a thread of its own. The disk's speed is
// measured once, soon after the start and only while nothing records.
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "rig/preflight.h"

namespace rotunda::rig {

class PreflightWatch {
 public:
  // `status` is asked each time, on the watch's thread.
  PreflightWatch(const config::RigConfig& rig, std::function<RigStatus()> status);

  std::vector<Finding> findings() const;  // that are not good; none before the first look

 private:
  void run(std::stop_token stop);
  std::vector<Finding> look(const std::stop_token& stop);
  void try_disk(const DiskFacts& disk, const std::stop_token& stop);
  bool quiet() const;  // nothing records now

  config::RigConfig rig_;
  std::function<RigStatus()> status_;
  bool disk_tried_ = false;  // these two: the watch's thread only
  std::optional<double> disk_speed_;
  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<Finding> findings_;
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
