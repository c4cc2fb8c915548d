#include "rig/daemon/rig_daemon.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <tbb/info.h>

#include <algorithm>
#include <filesystem>

#include "capture/base/host_clock.h"
#include "capture/frame.h"
#include "config/errors.h"
#include "rig/camera_portraits.h"
#include "rig/daemon/plate_recording.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookAfter = 200ms;  // a take has ended, cameras have come back: live again at the latest after this
// From a session's start to every camera's first frame, besides the triggers' lead.
constexpr double kFirstFrames_s = 1.0;
constexpr auto kBlinkTime = 2000ms;
constexpr auto kPortraitTime = 6s;  // going live, the first triggers, a look at every picture

double seconds_since(std::chrono::steady_clock::time_point moment) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - moment).count();
}

using Microseconds = std::chrono::duration<double, std::micro>;

// A JPEG's size is not known before: a byte a pixel is more than cameras send.
double image_bytes_of(const CameraStatus& camera) {
  const auto width = static_cast<int>(camera.width), height = static_cast<int>(camera.height);
  const auto format = capture::pixel_format_from(camera.pixel_format).value_or(capture::PixelFormat::mono8);
  const bool jpeg = format == capture::PixelFormat::mjpeg;
  return static_cast<double>(capture::image_bytes(width, height, jpeg ? capture::PixelFormat::mono8 : format));
}

double bytes_per_second(const RigStatus& status) {
  double bytes = 0.0;
  for (const auto& camera : status.cameras) bytes += image_bytes_of(camera);
  return bytes * status.rate_hz;
}

// The takes' folder is made with the first take: look at the nearest folder above that is there.
std::uint64_t free_bytes(std::filesystem::path folder) {
  std::error_code error;
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  const auto space = std::filesystem::space(folder, error);
  return error ? 0 : space.available;
}

// A frame set a core at once, as far as there is one for each.
constexpr int kMostWorkers = 4;

std::unique_ptr<LiveSurfaces> make_surfaces(const config::RigConfig& rig, bool wanted, LiveMocap& mocap) {
  if (!wanted) return nullptr;
  const auto make_work = [rig](const auto& cameras, const auto& first) {
    return live_work(rig, plate_folder(rig.storage.takes), cameras, first);
  };
  return std::make_unique<LiveSurfaces>(
      make_work, static_cast<std::size_t>(std::clamp(tbb::info::default_concurrency(), 1, kMostWorkers)),
      LiveSurfaces::Onlooker{.looks = [&mocap] { return mocap.is_watched(); },
                             .tell = [&mocap](const auto& set, const auto& work,
                                              const auto& views) { mocap.offer(set, work.cameras, views); }});
}

}  // namespace

RigDaemon::RigDaemon(const config::RigConfig& rig, bool with_surfaces)
    : rig_(rig),
      fleet_(rig),
      surfaces_(make_surfaces(rig, with_surfaces, mocap_)),
      review_(with_surfaces ? std::make_unique<TakeReview>([this] { return recording(); }) : nullptr),
      live_keeper_([this](std::stop_token stop) { keep_live(std::move(stop)); }),
      preflight_(std::in_place, rig_, [this] { return session_status(); }) {}

RigDaemon::~RigDaemon() {
  preflight_.reset();
  live_keeper_ = {};
}

bool RigDaemon::recording_locked() const {
  return take_ && !take_->progress().closed;
}

std::string RigDaemon::state_locked() const {
  if (recording_locked()) return take_->stopping() ? "stopping" : "recording";
  if (live_) return "live";
  return fleet_.streaming() > 0 ? "armed" : "idle";
}

RigStatus RigDaemon::status() const {
  auto status = session_status();
  status.preflight = preflight_->findings();
  return status;
}

RigStatus RigDaemon::session_status() const {
  const std::lock_guard lock(mutex_);
  RigStatus status{.rig = rig_.name, .state = state_locked(), .trigger = std::string(to_string(fleet_.trigger_mode()))};
  status.rate_hz = rig_.trigger.rate_hz;
  status.takes_folder = rig_.storage.takes;
  status.disk_free_bytes = free_bytes(rig_.storage.takes);
  const double expected_s = expected_locked();
  for (const auto& worker : fleet_.workers()) {
    auto& camera = status.cameras.emplace_back(worker->status());
    if (expected_s > 0.0) camera.silent_s = std::min(expected_s, seconds_since(worker->last_frame()));
    if (const auto health = watch_.health(camera.name)) {
      camera.clipped = health->clipped;
      camera.focus = health->focus;
    }
  }
  const double usable = static_cast<double>(status.disk_free_bytes) - rig_.storage.reserve_mb * 1e6;
  if (const double rate = bytes_per_second(status); rate > 0.0) status.seconds_left = std::max(0.0, usable / rate);
  if (take_) {
    status.take = take_->progress();
    status.queued_frame_sets = take_->queued();
  }
  if (take_ && !live_)
    for (const auto& [name, frames] : take_->too_slow_for())
      for (auto& camera : status.cameras)
        if (camera.name == name) camera.missing.emplace(to_string(capture::HoleReason::disk_too_slow), frames);
  if (surfaces_) status.surfaces = surfaces_->status();
  if (live_ || take_) add_session(status, live_ ? live_->stream() : take_->stream());
  for (auto& problem : capture::ptp_domain_problems(fleet_.clocks())) status.warnings.push_back(std::move(problem));
  if (!live_problem_.empty()) status.warnings.push_back(live_problem_);
  if (rig_.trigger.mode == "action" && fleet_.trigger_mode() == capture::TriggerMode::software)
    status.warnings.push_back(
        "a camera knows no scheduled actions: all are triggered by software, one after the other");
  return status;
}

// For how long every camera should have sent frames by now: the first triggers of a session take a moment.
double RigDaemon::expected_locked() const {
  if (!live_ && !recording_locked()) return 0.0;
  return std::max(0.0,
                  seconds_since(session_begun_) - kFirstFrames_s - rig_.trigger.lead_periods / rig_.trigger.rate_hz);
}

// Holes by cause: of the session that gives the cameras their triggers now, or gave them last.
void RigDaemon::add_session(RigStatus& status, const FrameSetStream& stream) const {
  status.late_triggers = stream.late_triggers();
  status.late_frames = stream.late_frames();
  status.warnings = stream.warnings();
  const auto counts = stream.counts();
  const auto sync = stream.sync();
  status.spread_median_us = Microseconds(sync.spread_median).count();
  status.spread_p99_us = Microseconds(sync.spread_p99).count();
  for (auto& camera : status.cameras) {
    const auto place = std::find(stream.cameras().begin(), stream.cameras().end(), camera.name);
    if (place == stream.cameras().end()) continue;
    const auto slot = static_cast<std::size_t>(place - stream.cameras().begin());
    for (const auto& [why, holes] : counts.cameras[slot].missing_because)
      camera.missing.emplace(capture::to_string(why), holes);
    if (counts.cameras[slot].in_sets == 0) continue;
    camera.offset_us = Microseconds(sync.cameras[slot].offset).count();
    camera.drift_ppm = sync.cameras[slot].drift_ppm;
  }
}

TakeProgress RigDaemon::annotate_take(const TakeAnnotation& annotation) {
  const std::lock_guard lock(mutex_);
  if (!take_) throw DeviceError("rig", "no take was recorded since the daemon started; name one: rotunda take note");
  take_->annotate(annotation);
  return take_->progress();
}

void RigDaemon::require_free_locked() const {
  if (plating_) throw DeviceError("rig", "the empty studio is being recorded; wait until it is done");
  if (recording_locked())
    throw DeviceError(
        "rig", fmt::format("take {} is still recording; stop it first: rotunda take stop", take_->progress().name));
}

PlateReport RigDaemon::record_plate(std::uint64_t frame_sets) {
  constexpr std::uint64_t kFewest = 2, kMost = 256;
  if (frame_sets < kFewest || frame_sets > kMost)
    throw InvalidInput(
        fmt::format("the empty studio is the mean of {} to {} pictures, not {}", kFewest, kMost, frame_sets));
  fleet_.wait_until_tried({});
  {
    const std::lock_guard lock(mutex_);
    require_free_locked();
    plating_ = true;
    live_.reset();
  }
  const auto free_again = [this] {
    const std::lock_guard lock(mutex_);
    plating_ = false;
  };
  try {
    auto report = rig::record_plate(rig_, fleet_, frame_sets);
    free_again();
    return report;
  } catch (...) {
    free_again();
    throw;
  }
}

std::shared_ptr<TakeSession> RigDaemon::start_take(const TakeRequest& request) {
  fleet_.wait_until_tried({});  // a take asked for while the daemon starts is one with all cameras
  const std::lock_guard lock(mutex_);
  require_free_locked();
  live_.reset();
  take_.reset();
  renew_surfaces();
  take_ = std::make_shared<TakeSession>(rig_, request, fleet_,
                                        [this](const auto& set, const auto& cameras) { look_at(set, cameras); });
  session_begun_ = std::chrono::steady_clock::now();
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

std::vector<CameraWorker*> RigDaemon::workers_called(const std::string& name) const {
  std::vector<CameraWorker*> workers;
  std::vector<std::string> known;
  for (const auto& worker : fleet_.workers()) {
    known.push_back(worker->settings().camera);
    if (name.empty() || name == known.back()) workers.push_back(worker.get());
  }
  if (workers.empty())
    throw InvalidInput(fmt::format("the rig has no camera {}; it has {}", name, fmt::join(known, ", ")));
  return workers;
}

bool RigDaemon::recording() const {
  const std::lock_guard lock(mutex_);
  return recording_locked();
}

bool RigDaemon::go_live_for_a_moment() {
  const std::lock_guard lock(mutex_);
  if (live_wanted_ || plating_ || recording_locked()) return false;
  live_wanted_ = true;
  go_live_or_not();
  return true;
}

std::vector<IdentifiedCamera> RigDaemon::identify(const IdentifyRequest& request) {
  fleet_.wait_until_tried({});
  const auto workers = workers_called(request.camera);
  const auto asked = std::chrono::steady_clock::now();
  const bool blink = request.blink && !recording();  // no light flickers in a take
  for (auto* worker : workers)
    if (blink) worker->blink(kBlinkTime);
  const bool only_now = go_live_for_a_moment();
  const auto pictured = [&](const CameraWorker* worker) {
    return !worker->streaming() || !watch_.portrait(worker->settings().camera, asked).empty();
  };
  const auto wait_until = asked + (blink ? kBlinkTime : 0ms);
  const auto give_up = asked + kPortraitTime;
  while (std::chrono::steady_clock::now() < give_up &&
         (std::chrono::steady_clock::now() < wait_until || !std::all_of(workers.begin(), workers.end(), pictured)))
    std::this_thread::sleep_for(20ms);
  std::vector<CameraPortrait> portraits;
  for (const auto* worker : workers) {
    const auto status = worker->status();
    portraits.push_back({{.name = status.name,
                          .serial = status.serial,
                          .address = status.address.empty() ? status.device : status.address,
                          .model = status.model,
                          .problem = status.problem,
                          .blinked = blink && worker->has_light()},
                         watch_.portrait(status.name, asked)});
  }
  if (only_now) set_live(false);
  return write_contact_sheet(request.picture, portraits);
}

void RigDaemon::set_live(bool on) {
  const std::lock_guard lock(mutex_);
  live_wanted_ = on;
  if (!plating_ && !recording_locked()) go_live_or_not();
  live_changed_.notify_one();
}

void RigDaemon::look_at(const capture::FrameSet& set, const std::vector<capture::CameraId>& cameras) {
  watch_.offer(set);
  if (surfaces_) surfaces_->offer(set, cameras);
}

void RigDaemon::renew_surfaces() {
  if (surfaces_) surfaces_->renew();
}

void RigDaemon::go_live_or_not() {
  live_problem_.clear();
  if (!live_wanted_) return live_.reset();
  if (live_) return;
  try {
    renew_surfaces();
    live_ = std::make_unique<LiveSession>(rig_, fleet_,
                                          [this](const auto& set, const auto& cameras) { look_at(set, cameras); });
    session_begun_ = std::chrono::steady_clock::now();
  } catch (const std::exception& error) {
    live_problem_ = fmt::format("not live: {}", error.what());
  }
}

// Between takes the rig's clock follows this machine's when that was set; live pictures begin anew.
void RigDaemon::follow_clock() {
  const auto ahead = capture::host_clock_ahead();
  if (std::chrono::abs(ahead) < capture::kSmallestClockStep || recording_locked()) return;
  live_.reset();
  capture::follow_host_clock();
  spdlog::warn("this machine's clock was set by {:.3f} s; the rig follows",
               std::chrono::duration<double>(ahead).count());
}

void RigDaemon::review_closed_take() {
  if (!review_ || !rig_.calibration || !take_ || take_ == reviewed_.lock() || recording_locked()) return;
  reviewed_ = take_;
  if (take_->progress().frame_sets > 0) review_->add(take_->progress().folder);
}

// Live again after a take, or when cameras have come back.
void RigDaemon::keep_live(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "live keeper");
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    live_changed_.wait_for(lock, stop, kLookAfter, [] { return false; });
    follow_clock();
    review_closed_take();
    if (live_wanted_ && !live_ && !plating_ && !recording_locked() && !stop.stop_requested()) go_live_or_not();
  }
}

}  // namespace rotunda::rig
