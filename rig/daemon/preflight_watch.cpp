#include "rig/daemon/preflight_watch.h"

#include <pthread.h>

#include <algorithm>

#include "rig/machine_facts.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookEvery = 2s;
// Enough to see what a disk does, little enough for a card: 64 MB, or half a second.
constexpr std::size_t kTrialBytes = 64'000'000;
constexpr auto kTrialTime = 500ms;

}  // namespace

PreflightWatch::PreflightWatch(const config::RigConfig& rig, std::function<RigStatus()> status)
    : rig_(rig), status_(std::move(status)), thread_([this](std::stop_token stop) { run(std::move(stop)); }) {}

std::vector<Finding> PreflightWatch::findings() const {
  const std::lock_guard lock(mutex_);
  return findings_;
}

bool PreflightWatch::quiet() const {
  const auto state = status_().state;
  return state != "recording" && state != "stopping";
}

void PreflightWatch::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "preflight");
  std::optional<double> disk;
  while (!stop.stop_requested()) {
    auto facts = machine_facts(rig_.storage.takes, rig_);
    if (!disk && facts.disk.writable)
      disk = measure_disk(facts.disk.folder, {.bytes = kTrialBytes, .time = kTrialTime, .go_on = [&] {
                                                return !stop.stop_requested() && quiet();
                                              }});
    facts.disk.bytes_per_second = disk;
    facts.status = status_();
    auto findings = preflight(facts);
    std::erase_if(findings, [](const Finding& finding) { return finding.verdict == Verdict::good; });
    std::unique_lock lock(mutex_);
    findings_ = std::move(findings);
    wake_.wait_for(lock, stop, kLookEvery, [] { return false; });
  }
}

}  // namespace rotunda::rig
