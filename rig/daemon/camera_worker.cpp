#include "rig/daemon/camera_worker.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
constexpr auto kRetryAfter = 2s;   // between attempts to open a camera that does not answer
constexpr auto kHealthEvery = 1s;  // the camera is asked for its clock and temperature
constexpr auto kClockPulse = 200ms;
constexpr auto kAnswersWithin = 1750ms;  // three of GVCP's tries: a camera that is merely busy answers one of them
constexpr auto kLookAfter = 100ms;       // a lost camera is noticed at the latest after this

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

std::chrono::steady_clock::time_point CameraWorker::last_frame() const {
  const std::lock_guard lock(mutex_);
  return last_frame_;
}

bool CameraWorker::streaming() const {
  const std::lock_guard lock(mutex_);
  return streams_;
}

void CameraWorker::tell_silence(bool silent) {
  const std::lock_guard lock(mutex_);
  silence_ends_ = false;
  if (silent_ == silent) return;
  silent_ = silent;
  if (!streams_) return;
  probe_wanted_ = silent;
  status_.state = silent ? "lost" : "streaming";
  status_.problem = problems_of(description_, health_, silent_, ailment_);
  wake_.notify_one();
}

void CameraWorker::end_silence() {
  const std::lock_guard lock(mutex_);
  silence_ends_ = probe_wanted_ = silent_;
  wake_.notify_one();
}

bool CameraWorker::gone() const {
  const std::lock_guard lock(mutex_);
  return !streams_ || (asked_at_ && std::chrono::steady_clock::now() - *asked_at_ >= kAnswersWithin);
}

// What is asked may take seconds of a camera that is not there: gone() sees it.
void CameraWorker::ask(const std::function<void()>& question) {
  struct Asking {
    explicit Asking(CameraWorker& asked_by) : worker(asked_by) { set(std::chrono::steady_clock::now()); }
    ~Asking() { set(std::nullopt); }
    void set(std::optional<std::chrono::steady_clock::time_point> moment) {
      const std::lock_guard lock(worker.mutex_);
      worker.asked_at_ = moment;
    }
    CameraWorker& worker;
  };
  const Asking asking(*this);
  question();
}

bool CameraWorker::tried() const {
  const std::lock_guard lock(mutex_);
  return tried_;
}

capture::SourceDescription CameraWorker::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

capture::ClockState CameraWorker::clock() const {
  const std::lock_guard lock(mutex_);
  return health_.clock;
}

std::optional<capture::LinkLoad> CameraWorker::load() const {
  const std::lock_guard lock(mutex_);
  if (!streams_) return std::nullopt;
  return capture::LinkLoad{settings_.camera, description_.link,
                           capture::image_bytes(description_.width, description_.height, description_.format),
                           static_cast<int>(status_.packet_size)};
}

void CameraWorker::set_pacing(const capture::StreamPacing& pacing) {
  const std::lock_guard lock(mutex_);
  wanted_pacing_ = pacing;
  wake_.notify_one();
}

bool CameraWorker::paced() const {
  const std::lock_guard lock(mutex_);
  return pacing_ == wanted_pacing_;
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
  streams_ = false;
  wake_.notify_one();
}

void CameraWorker::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), settings_.camera.substr(0, 15).c_str());
  while (!stop.stop_requested()) {
    try {
      bring_up(stop);
      serve(stop);
      take_down("");
    } catch (const std::exception& error) {
      take_down(error.what());
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kRetryAfter, [] { return false; });
    }
  }
}

void CameraWorker::bring_up(const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    settings_.trigger = wanted_mode_;
    software_triggers_ = 0;
  }
  open_and_arm();
  wait_for_clock(stop);
  {
    const std::lock_guard lock(mutex_);
    pacing_ = {};  // whatever it was before
  }
  pace();
  source_->start(sink_, incomplete_sink_);
  const auto description = source_->description();
  spdlog::info("{}: {} {} ({}) streams {} x {} {}", settings_.camera, description.vendor, description.model,
               settings_.device, description.width, description.height, capture::to_string(description.format));
  for (const auto& warning : description.warnings) spdlog::warn("{}: {}", settings_.camera, warning);
  {
    const std::lock_guard lock(mutex_);
    description_ = description;
  }
  refresh_status();
}

// A PTP clock takes seconds to follow its master. One that does not in time streams all the same, its time stamps by a
// model of its clock, and says so.
void CameraWorker::wait_for_clock(const std::stop_token& stop) {
  const auto give_up = std::chrono::steady_clock::now() + settings_.clock_patience;
  for (look(); std::chrono::steady_clock::now() < give_up && !stop.stop_requested(); look()) {
    std::unique_lock lock(mutex_);
    if (health_.clock.settled || health_.clock.kind.empty()) return;
    wake_.wait_for(lock, stop, kClockPulse, [] { return false; });
  }
}

// A camera that was never told a delay keeps the one its maker or user gave it.
void CameraWorker::pace() {
  capture::StreamPacing wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted = wanted_pacing_;
    if (wanted == pacing_) return;
  }
  const bool streams = source_->state() == capture::SourceState::streaming;
  if (streams) source_->stop();
  source_->pace(wanted);
  if (streams) source_->start(sink_, incomplete_sink_);
  const std::lock_guard lock(mutex_);
  pacing_ = wanted;
}

void CameraWorker::look() {
  capture::SourceHealth health;
  ask([&] { health = source_->look(); });
  next_look_ = std::chrono::steady_clock::now() + kHealthEvery;
  const std::lock_guard lock(mutex_);
  if (!health.clock.problem.empty() && health_.clock.problem.empty())
    spdlog::warn("{}: {}", settings_.camera, health.clock.problem);
  health_ = std::move(health);
  if (std::exchange(silence_ends_, false)) silent_ = false;
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
      wake_.wait_for(lock, stop, kLookAfter, [this] {
        return software_triggers_ > 0 || probe_wanted_ || wanted_mode_ != settings_.trigger ||
               wanted_pacing_ != pacing_;
      });
      if (stop.stop_requested() || wanted_mode_ != settings_.trigger) return;
      triggers = std::exchange(software_triggers_, 0);
      if (std::exchange(probe_wanted_, false)) next_look_ = {};
    }
    pace();
    for (; triggers > 0; --triggers) ask([&] { source_->software_trigger(); });
    heal();
    if (std::chrono::steady_clock::now() >= next_look_) look();  // behind the triggers: it takes some milliseconds
    refresh_status();
    switch_light();
    if (source_->state() == capture::SourceState::lost)
      throw DeviceError(settings_.camera, "no longer answers; check its cable and power (it is tried again every " +
                                              std::to_string(kRetryAfter.count()) + " s)");
  }
}

// Told until the camera is opened anew.
void CameraWorker::heal() {
  std::optional<std::string> ailment;
  ask([&] { ailment = source_->heal(); });
  if (!ailment) return;
  spdlog::warn("{}", *ailment);
  const std::lock_guard lock(mutex_);
  ailment_ = *ailment;
}

void CameraWorker::blink(std::chrono::milliseconds time) {
  const std::lock_guard lock(mutex_);
  blink_until_ = std::chrono::steady_clock::now() + time;
  has_light_ = false;
}

bool CameraWorker::has_light() const {
  const std::lock_guard lock(mutex_);
  return has_light_;
}

// Other with each of the thread's looks while it blinks, off afterwards.
void CameraWorker::switch_light() {
  bool blinks = false;
  {
    const std::lock_guard lock(mutex_);
    blinks = std::chrono::steady_clock::now() < blink_until_;
  }
  if (!blinks && !lit_) return;
  const bool on = blinks && !lit_;
  const bool done = source_->show_light(on);
  lit_ = on && done;
  const std::lock_guard lock(mutex_);
  if (done) has_light_ = true;
}

void CameraWorker::refresh_status() {
  const auto stats = source_->stats();
  const auto state = source_->state();
  const std::lock_guard lock(mutex_);
  tried_ = true;
  streams_ = state == capture::SourceState::streaming;
  status_.state = streams_ && silent_ ? "lost" : std::string(capture::to_string(state));
  if (stats.frames != status_.frames) last_frame_ = std::chrono::steady_clock::now();
  tell_stats(status_, stats);
  tell_description(status_, description_);
  tell_health(status_, health_);
  status_.rate_hz = rate_.measure(stats.frames, std::chrono::steady_clock::now());
  status_.problem = problems_of(description_, health_, silent_, ailment_);
}

void CameraWorker::take_down(const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    tried_ = true;
    if (!problem.empty() && problem != status_.problem) spdlog::warn("{}", problem);
    status_.problem = problem;
    status_.state = problem.empty() ? "closed" : "lost";
    streams_ = false;
    probe_wanted_ = false;
    ailment_.clear();
    if (std::exchange(silence_ends_, false)) silent_ = false;  // it is lost by its own state, and answers when opened
    status_.rate_hz = 0.0;
    health_ = {};
    tell_health(status_, health_);
    rate_.forget();
  }
  try {
    if (source_->state() == capture::SourceState::streaming) source_->stop();
  } catch (const std::exception& error) {
    spdlog::debug("{}: while stopping: {}", settings_.camera, error.what());
  }
  source_->close();
}

}  // namespace rotunda::rig
