#include "rig/daemon/rig_daemon.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

double bytes_per_second(const RigStatus& status) {
  double bytes = 0.0;
  for (const auto& camera : status.cameras) bytes += static_cast<double>(camera.width) * camera.height;
  return bytes * status.rate_hz;
}

// The takes' folder is made with the first take: look at the nearest folder above that is there.
std::uint64_t free_bytes(std::filesystem::path folder) {
  std::error_code error;
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  const auto space = std::filesystem::space(folder, error);
  return error ? 0 : space.available;
}

}  // namespace

RigDaemon::RigDaemon(const config::RigConfig& rig) : rig_(rig), fleet_(rig) {}

RigDaemon::~RigDaemon() = default;

std::string RigDaemon::state_locked() const {
  if (take_ && !take_->progress().closed) return take_->stopping() ? "stopping" : "recording";
  return fleet_.streaming() > 0 ? "armed" : "idle";
}

RigStatus RigDaemon::status() const {
  const std::lock_guard lock(mutex_);
  RigStatus status{.rig = rig_.name, .state = state_locked(), .trigger = std::string(to_string(fleet_.trigger_mode()))};
  status.rate_hz = rig_.trigger.rate_hz;
  status.takes_folder = rig_.storage.takes;
  status.disk_free_bytes = free_bytes(rig_.storage.takes);
  for (const auto& worker : fleet_.workers()) status.cameras.push_back(worker->status());
  const double usable = static_cast<double>(status.disk_free_bytes) - rig_.storage.reserve_mb * 1e6;
  if (const double rate = bytes_per_second(status); rate > 0.0) status.seconds_left = std::max(0.0, usable / rate);
  if (take_) {
    status.take = take_->progress();
    status.late_triggers = take_->late_triggers();
    status.late_frames = take_->late_frames();
    status.queued_frame_sets = take_->queued();
    status.warnings = take_->trigger_warnings();
  }
  if (rig_.trigger.mode == "action" && fleet_.trigger_mode() == capture::TriggerMode::software)
    status.warnings.push_back(
        "a camera knows no scheduled actions: all are triggered by software, one after the other");
  return status;
}

std::shared_ptr<TakeSession> RigDaemon::start_take(const TakeRequest& request) {
  fleet_.wait_until_tried({});  // a take asked for while the daemon starts is one with all cameras
  const std::lock_guard lock(mutex_);
  if (take_ && !take_->progress().closed)
    throw DeviceError(
        "rig", fmt::format("take {} is still recording; stop it first: rotunda take stop", take_->progress().name));
  take_.reset();
  take_ = std::make_shared<TakeSession>(rig_, request, fleet_);
  return take_;
}

TakeProgress RigDaemon::stop_take() {
  std::shared_ptr<TakeSession> take;
  {
    const std::lock_guard lock(mutex_);
    take = take_;
  }
  if (!take || take->progress().closed) throw DeviceError("rig", "no take is recording");
  take->request_stop();
  TakeProgress progress = take->progress();
  while (!progress.closed) progress = take->wait_for_change(progress, 100ms);
  return progress;
}

}  // namespace rotunda::rig
