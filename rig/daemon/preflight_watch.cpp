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

// A disk that takes a recording is not tried as well; the trial comes once.
void PreflightWatch::try_disk(const DiskFacts& disk, const std::stop_token& stop) {
  if (disk_tried_ || !disk.writable || !quiet()) return;
  disk_speed_ = measure_disk(disk.folder, {.bytes = kTrialBytes, .time = kTrialTime, .go_on = [&] {
                                             return !stop.stop_requested() && quiet();
                                           }});
  disk_tried_ = disk_speed_ || quiet();
}

std::vector<Finding> PreflightWatch::look(const std::stop_token& stop) {
  auto facts = machine_facts(rig_.storage.takes, rig_);
  try_disk(facts.disk, stop);
  facts.disk.bytes_per_second = disk_speed_;
  facts.status = status_();
  auto findings = preflight(facts);
  std::erase_if(findings, [](const Finding& finding) { return finding.verdict == Verdict::good; });
  return findings;
}

void PreflightWatch::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "preflight");
  while (!stop.stop_requested()) {
    std::vector<Finding> findings;
    try {
      findings = look(stop);
    } catch (const std::exception& error) {
      findings = {
          {"preflight", Verdict::note, error.what(), "the machine was not looked at; rotunda doctor may tell more"}};
    }
    std::unique_lock lock(mutex_);
    findings_ = std::move(findings);
    wake_.wait_for(lock, stop, kLookEvery, [] { return false; });
  }
}

}  // namespace rotunda::rig
