#pragma once
// What each stage of a long piece of work costs: how often it ran, wall and CPU time each time. Safe from many threads.
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace rotunda::recon {

struct StageCost {
  std::string stage;
  std::size_t count = 0;
  double median_ms = 0.0;      // wall, of one run
  double median_cpu_ms = 0.0;  // of the thread that ran it
  double cpu_s = 0.0;          // of all runs
};

class StageClock {
 public:
  // Runs `work`, whose CPU time is all on this thread, as one run of `stage`.
  template <class Work>
  auto run(const std::string& stage, Work&& work) {
    const Reading reading(*this, stage);
    return work();
  }

  // In the order in which the stages first ended.
  std::vector<StageCost> costs() const;

 private:
  class Reading {
   public:
    Reading(StageClock& clock, const std::string& stage);
    ~Reading();

   private:
    StageClock& clock_;
    const std::string& stage_;
    std::chrono::steady_clock::time_point begun_;
    double cpu_begun_;
  };
  struct Runs {
    std::vector<double> wall_ms, cpu_ms;
  };

  mutable std::mutex mutex_;
  std::vector<std::string> order_;
  std::map<std::string, Runs> runs_;
};

}  // namespace rotunda::recon
