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
  // Laps of a loop that is not ours to wrap: each lap is one run of `stage`, from the lap before or from the start.
  class Laps {
   public:
    Laps(StageClock& clock, std::string stage);
    void lap();

   private:
    StageClock& clock_;
    std::string stage_;
    std::chrono::steady_clock::time_point wall_;
    double cpu_ms_;
  };

  // Runs `work`, whose CPU time is all on this thread, as one run of `stage`.
  template <class Work>
  auto run(const std::string& stage, Work&& work) {
    struct Reading {
      Laps laps;
      ~Reading() { laps.lap(); }
    };
    Reading reading{Laps(*this, stage)};
    return work();
  }

  // In the order in which the stages first ended.
  std::vector<StageCost> costs() const;

 private:
  void add(const std::string& stage, double wall_ms, double cpu_ms);
  struct Runs {
    std::vector<double> wall_ms, cpu_ms;
  };

  mutable std::mutex mutex_;
  std::vector<std::string> order_;
  std::map<std::string, Runs> runs_;
};

}  // namespace rotunda::recon
