#include "recon/stage_clock.h"

#include <algorithm>
#include <ctime>
#include <numeric>

#include "config/median.h"

namespace rotunda::recon {
namespace {

double thread_cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

}  // namespace

StageClock::Laps::Laps(StageClock& clock, std::string stage)
    : clock_(clock), stage_(std::move(stage)), wall_(std::chrono::steady_clock::now()), cpu_ms_(thread_cpu_ms()) {}

void StageClock::Laps::lap() {
  const auto wall = std::chrono::steady_clock::now();
  const double cpu_ms = thread_cpu_ms();
  clock_.add(stage_, std::chrono::duration<double, std::milli>(wall - wall_).count(), cpu_ms - cpu_ms_);
  wall_ = wall;
  cpu_ms_ = cpu_ms;
}

void StageClock::add(const std::string& stage, double wall_ms, double cpu_ms) {
  const std::lock_guard lock(mutex_);
  auto& runs = runs_[stage];
  if (runs.wall_ms.empty()) order_.push_back(stage);
  runs.wall_ms.push_back(wall_ms);
  runs.cpu_ms.push_back(cpu_ms);
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
