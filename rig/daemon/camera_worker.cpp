#include "rig/daemon/camera_worker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
constexpr auto kRetryAfter = 2s;  // between attempts to open a camera that does not answer
constexpr auto kRateOver = 1s;
constexpr auto kLookAfter = 100ms;  // a lost camera is noticed at the latest after this

}  // namespace

CameraWorker::CameraWorker(capture::SourceSettings settings, capture::FrameSink sink,
                           capture::IncompleteSink incomplete_sink)
    : settings_(std::move(settings)),
      sink_(std::move(sink)),
      incomplete_sink_(std::move(incomplete_sink)),
      source_(capture::make_source(settings_)),
      wanted_mode_(settings_.trigger),
      armed_mode_(settings_.trigger) {
  status_.name = settings_.camera;
  status_.device = settings_.device;
  status_.state = "closed";
  thread_ = std::jthread([this](std::stop_token stop) { run(std::move(stop)); });
}

CameraWorker::~CameraWorker() = default;

CameraStatus CameraWorker::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool CameraWorker::streaming() const {
  const std::lock_guard lock(mutex_);
  return status_.state == "streaming";
}

bool CameraWorker::tried() const {
  const std::lock_guard lock(mutex_);
  return tried_;
}

capture::SourceDescription CameraWorker::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

void CameraWorker::request_software_trigger() {
  const std::lock_guard lock(mutex_);
  ++software_triggers_;
  wake_.notify_one();
}

capture::TriggerMode CameraWorker::trigger_mode() const {
  const std::lock_guard lock(mutex_);
  return armed_mode_;
}

void CameraWorker::set_trigger_mode(capture::TriggerMode mode) {
  const std::lock_guard lock(mutex_);
  if (wanted_mode_ == mode) return;
  wanted_mode_ = mode;
  status_.state = "closed";  // until it streams in the new mode
  wake_.notify_one();
}

void CameraWorker::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), settings_.camera.substr(0, 15).c_str());
  while (!stop.stop_requested()) {
    try {
      bring_up();
      serve(stop);
      take_down("");
    } catch (const std::exception& error) {
      take_down(error.what());
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kRetryAfter, [] { return false; });
    }
  }
}

void CameraWorker::bring_up() {
  {
    const std::lock_guard lock(mutex_);
    settings_.trigger = wanted_mode_;
    software_triggers_ = 0;
  }
  open_and_arm();
  source_->start(sink_, incomplete_sink_);
  const auto description = source_->description();
  spdlog::info("{}: {} {} ({}) streams {} x {} {}", settings_.camera, description.vendor, description.model,
               settings_.device, description.width, description.height, capture::to_string(description.format));
  for (const auto& warning : description.warnings) spdlog::warn("{}: {}", settings_.camera, warning);
  {
    const std::lock_guard lock(mutex_);
    description_ = description;
    status_.problem = fmt::format("{}", fmt::join(description.warnings, "; "));
  }
  refresh_status();
}

void CameraWorker::open_and_arm() {
  source_ = capture::make_source(settings_);
  source_->open();
  try {
    source_->arm();
  } catch (const DeviceError& error) {
    if (settings_.trigger != capture::TriggerMode::action) throw;
    spdlog::warn("{}; trying software triggers instead", error.what());
    source_->close();
    auto settings = settings_;
    settings.trigger = capture::TriggerMode::software;
    source_ = capture::make_source(settings);
    source_->open();
    source_->arm();
    settings_.trigger = capture::TriggerMode::software;
  }
  const std::lock_guard lock(mutex_);
  armed_mode_ = wanted_mode_ = settings_.trigger;
}

void CameraWorker::serve(std::stop_token stop) {
  for (;;) {
    std::uint64_t triggers = 0;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kLookAfter,
                     [this] { return software_triggers_ > 0 || wanted_mode_ != settings_.trigger; });
      if (stop.stop_requested() || wanted_mode_ != settings_.trigger) return;
      triggers = std::exchange(software_triggers_, 0);
    }
    for (; triggers > 0; --triggers) source_->software_trigger();
    heal();
    refresh_status();
    if (source_->state() == capture::SourceState::lost)
      throw DeviceError(settings_.camera, "no longer answers; check its cable and power (it is tried again every " +
                                              std::to_string(kRetryAfter.count()) + " s)");
  }
}

// Told until the camera is opened anew.
void CameraWorker::heal() {
  const auto ailment = source_->heal();
  if (!ailment) return;
  spdlog::warn("{}", *ailment);
  const std::lock_guard lock(mutex_);
  status_.problem = *ailment;
}

void CameraWorker::refresh_status() {
  const auto stats = source_->stats();
  const auto state = source_->state();
  const std::lock_guard lock(mutex_);
  tried_ = true;
  status_.state = capture::to_string(state);
  status_.frames = stats.frames;
  status_.rate_hz = measured_rate(stats.frames);
  status_.incomplete = stats.incomplete;
  status_.dropped = stats.dropped;
  status_.resend_requests = stats.resend_requests;
  status_.packet_size = static_cast<std::uint32_t>(stats.packet_size);
  status_.socket_buffer_bytes = static_cast<std::uint32_t>(stats.socket_buffer_bytes);
  status_.model = description_.model;
  status_.serial = description_.serial;
  status_.width = static_cast<std::uint32_t>(description_.width);
  status_.height = static_cast<std::uint32_t>(description_.height);
  status_.pixel_format = capture::to_string(description_.format);
}

// Frames a second over the last second or so.
double CameraWorker::measured_rate(std::uint64_t frames) {
  const auto now = std::chrono::steady_clock::now();
  if (!frame_counts_.empty() && frames < frame_counts_.back().second) frame_counts_.clear();  // opened anew
  frame_counts_.emplace_back(now, frames);
  while (frame_counts_.size() > 2 && now - frame_counts_[1].first >= kRateOver) frame_counts_.pop_front();
  const std::chrono::duration<double> span = now - frame_counts_.front().first;
  if (span < kRateOver / 2) return 0.0;
  return static_cast<double>(frames - frame_counts_.front().second) / span.count();
}

void CameraWorker::take_down(const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    tried_ = true;
    if (!problem.empty() && problem != status_.problem) spdlog::warn("{}", problem);
    status_.problem = problem;
    status_.state = problem.empty() ? "closed" : "lost";
    status_.rate_hz = 0.0;
    frame_counts_.clear();
  }
  try {
    source_->stop();
    source_->close();
  } catch (const std::exception& error) {
    spdlog::debug("{}: while closing: {}", settings_.camera, error.what());
  }
}

}  // namespace rotunda::rig
