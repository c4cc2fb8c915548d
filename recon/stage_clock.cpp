#include "recon/stage_clock.h"

#include <algorithm>
#include <ctime>
#include <numeric>

namespace rotunda::recon {
namespace {

double thread_cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

StageClock::Reading::Reading(StageClock& clock, const std::string& stage)
    : clock_(clock), stage_(stage), begun_(std::chrono::steady_clock::now()), cpu_begun_(thread_cpu_ms()) {}

StageClock::Reading::~Reading() {
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begun_;
  const double cpu = thread_cpu_ms() - cpu_begun_;
  const std::lock_guard lock(clock_.mutex_);
  auto& runs = clock_.runs_[stage_];
  if (runs.wall_ms.empty()) clock_.order_.push_back(stage_);
  runs.wall_ms.push_back(wall.count());
  runs.cpu_ms.push_back(cpu);
}

std::vector<StageCost> StageClock::costs() const {
  const std::lock_guard lock(mutex_);
  std::vector<StageCost> costs;
  for (const auto& stage : order_) {
    const auto& runs = runs_.at(stage);
    costs.push_back({.stage = stage,
                     .count = runs.wall_ms.size(),
                     .median_ms = median(runs.wall_ms),
                     .median_cpu_ms = median(runs.cpu_ms),
                     .cpu_s = std::accumulate(runs.cpu_ms.begin(), runs.cpu_ms.end(), 0.0) * 1e-3});
  }
  return costs;
}

}  // namespace rotunda::recon
