#include "rig/daemon/camera_fleet.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

capture::TriggerMode trigger_mode_from(const std::string& word) {
  if (word == "action") return capture::TriggerMode::action;
  if (word == "line") return capture::TriggerMode::line;
  return word == "software" ? capture::TriggerMode::software : capture::TriggerMode::freerun;
}

// Beyond the recorder's queue a camera's frames wait in the assembler and in the kernel's hands.
constexpr int kBuffersBesidesQueue = 48;
constexpr auto kRearmTime = 5s;

template <class Done>
void wait_for(const std::vector<CameraWorker*>& workers, Done done) {
  const auto give_up = std::chrono::steady_clock::now() + kRearmTime;
  while (!std::all_of(workers.begin(), workers.end(), done) && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(20ms);
}

}  // namespace

capture::SourceSettings source_settings(const config::CameraConfig& camera, const config::RigConfig& rig) {
  capture::SourceSettings settings;
  settings.camera = camera.name;
  settings.kind = camera.source;
  settings.device = camera.device;
  settings.width = camera.width;
  settings.height = camera.height;
  settings.format = capture::pixel_format_from(camera.pixel_format).value_or(capture::PixelFormat::bayer_rg8);
  settings.exposure_us = camera.exposure_us;
  settings.gain_db = camera.gain_db;
  for (const auto& [name, value] : camera.controls) settings.controls.push_back({name, value});
  settings.offset_x = camera.offset_x;
  settings.offset_y = camera.offset_y;
  if (const auto& balance = camera.white_balance)
    settings.white_balance = {.auto_once = balance->auto_once, .red = balance->red, .blue = balance->blue};
  settings.user_set = camera.user_set;
  for (const auto& [name, value] : camera.features) settings.features.push_back({name, value});
  settings.frame_rate_hz = rig.trigger.rate_hz;
  settings.clock.use_ptp = rig.trigger.ptp;
  settings.clock.ptp_offset_limit = std::chrono::nanoseconds(std::llround(rig.trigger.ptp_offset_limit_us * 1e3));
  settings.clock_patience = std::chrono::milliseconds(std::llround(rig.trigger.ptp_wait_s * 1e3));
  settings.packet_size = camera.packet_size;
  settings.resend_budget = camera.resend_budget_percent / 100.0;
  settings.trigger = trigger_mode_from(rig.trigger.mode);
  settings.device_key = rig.trigger.device_key;
  settings.group_key = rig.trigger.group_key;
  settings.group_mask = rig.trigger.group_mask;
  settings.buffers_at_most = rig.storage.queue_frame_sets + kBuffersBesidesQueue;
  return settings;
}

CameraFleet::CameraFleet(const config::RigConfig& rig) : rig_mode_(trigger_mode_from(rig.trigger.mode)) {
  const auto deliver = [this](capture::Frame&& frame) {
    const std::lock_guard lock(receiver_mutex_);
    if (receiver_) receiver_->take_frame(std::move(frame));
  };
  const auto deliver_incomplete = [this](const capture::IncompleteFrame& incomplete) {
    const std::lock_guard lock(receiver_mutex_);
    if (receiver_) receiver_->take_incomplete(incomplete);
  };
  for (const auto& camera : rig.cameras)
    workers_.push_back(std::make_unique<CameraWorker>(source_settings(camera, rig), deliver, deliver_incomplete));
}

CameraFleet::~CameraFleet() {
  for (const auto& worker : workers_) worker->request_stop();
}

CameraWorker& CameraFleet::worker(const capture::CameraId& camera) const {
  for (const auto& worker : workers_)
    if (worker->settings().camera == camera) return *worker;
  throw InvalidInput("the rig has no camera " + camera);
}

bool CameraFleet::wait_until_tried(std::stop_token stop) const {
  const auto all_tried = [this] {
    return std::all_of(workers_.begin(), workers_.end(), [](const auto& worker) { return worker->tried(); });
  };
  while (!all_tried()) {
    if (stop.stop_requested()) return false;
    std::this_thread::sleep_for(20ms);
  }
  return true;
}

std::size_t CameraFleet::streaming() const {
  return static_cast<std::size_t>(
      std::count_if(workers_.begin(), workers_.end(), [](const auto& worker) { return worker->streaming(); }));
}

capture::TriggerMode CameraFleet::trigger_mode() const {
  const bool software = std::any_of(workers_.begin(), workers_.end(), [](const auto& worker) {
    return worker->streaming() && worker->trigger_mode() == capture::TriggerMode::software;
  });
  return software ? capture::TriggerMode::software : rig_mode_;
}

std::vector<capture::NamedClock> CameraFleet::clocks() const {
  std::vector<capture::NamedClock> clocks;
  for (const auto& worker : workers_)
    if (worker->streaming()) clocks.push_back({worker->settings().camera, worker->clock()});
  return clocks;
}

std::chrono::nanoseconds CameraFleet::behind_rig_clock() const {
  const auto all = clocks();
  if (all.empty()) return {};
  const auto moved = all.front().clock.moved;
  const bool same = std::all_of(all.begin(), all.end(), [&](const auto& one) { return one.clock.moved == moved; });
  return same ? moved : std::chrono::seconds{};
}

void CameraFleet::share_links(double rate_hz) {
  std::vector<CameraWorker*> sending;
  std::vector<capture::LinkLoad> loads;
  std::map<std::string, double> speeds;
  for (const auto& worker : workers_) {
    auto load = worker->load();
    if (!load) continue;
    const auto description = worker->description();
    if (description.link_bits_per_second > 0.0) speeds[load->link] = description.link_bits_per_second;
    sending.push_back(worker.get());
    loads.push_back(std::move(*load));
  }
  const auto plan = capture::plan_bandwidth(loads, speeds, rate_hz);
  for (const auto& link : plan.links)
    if (!link.fits) throw DeviceError("rig", "the cameras' pictures do not fit their link: " + link.arithmetic);
  for (std::size_t i = 0; i < sending.size(); ++i) sending[i]->set_pacing(plan.pacing[i]);
  wait_for(sending, [](const CameraWorker* worker) { return worker->paced(); });
}

void CameraFleet::agree_on_trigger_mode() {
  const auto mode = trigger_mode();
  std::vector<CameraWorker*> changing;
  for (const auto& worker : workers_)
    if (worker->streaming() && worker->trigger_mode() != mode) changing.push_back(worker.get());
  for (auto* worker : changing) worker->set_trigger_mode(mode);
  wait_for(changing, [](const CameraWorker* worker) { return worker->streaming(); });
}

void CameraFleet::set_receiver(FrameReceiver* receiver) {
  const std::lock_guard lock(receiver_mutex_);
  receiver_ = receiver;
}

void CameraFleet::release(const FrameReceiver* receiver) {
  const std::lock_guard lock(receiver_mutex_);
  if (receiver_ == receiver) receiver_ = nullptr;
}

}  // namespace rotunda::rig
