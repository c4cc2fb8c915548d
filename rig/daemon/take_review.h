#pragma once
// Makes takes ready to be looked at as soon as they are closed (recon/live_take.h), one after the other, in a thread of
// low priority that rests while another take is recorded. What fails is logged, no more: the take itself is whole.
#include <filesystem>
#include <functional>
#include <thread>

#include "capture/base/bounded_queue.h"

namespace rotunda::rig {

class TakeReview {
 public:
  explicit TakeReview(std::function<bool()> recording);
  void add(const std::filesystem::path& take);  // never waits

 private:
  void run(const std::stop_token& stop);
  void review(const std::filesystem::path& take, const std::stop_token& stop);

  const std::function<bool()> recording_;
  capture::BoundedQueue<std::filesystem::path> takes_{16};
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
