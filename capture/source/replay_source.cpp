#include "capture/source/replay_source.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "capture/sync/trigger_grid.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kUsualRate = 25.0;

class ReplaySource final : public Source {
 public:
  explicit ReplaySource(const SourceSettings& settings) : settings_(settings) {}
  ~ReplaySource() override { close(); }

  void open() override;
  void arm() override;
  void start(FrameSink frames, IncompleteSink incomplete) override;
  void stop() override;
  void software_trigger() override;
  void close() noexcept override;

  SourceState state() const override { return state_; }
  SourceStats stats() const override { return {.frames = frames_}; }
  SourceDescription description() const override;

 private:
  void become(SourceState next) { state_ = checked_transition(state_, next, settings_.camera); }
  void play_on_grid(const std::stop_token& stop);
  void play_on_triggers(const std::stop_token& stop);
  void send(std::uint64_t exposure, Timestamp moment);

  const SourceSettings settings_;
  std::atomic<SourceState> state_{SourceState::closed};
  std::atomic<std::uint64_t> frames_{0};
  std::unique_ptr<TakeReader> take_;
  std::size_t camera_ = 0;  // in the take
  FrameSink sink_;
  std::mutex mutex_;
  std::condition_variable_any triggered_;
  std::uint64_t triggers_ = 0;
  std::jthread thread_;
};

// The take is read once and in full: which frames there are. Its pixels are read as they are sent.
void ReplaySource::open() {
  become(SourceState::open);
  try {
    take_ = std::make_unique<TakeReader>(settings_.device);
    const auto& cameras = take_->info().cameras;
    const auto found = std::find_if(cameras.begin(), cameras.end(),
                                    [this](const TakeCamera& camera) { return camera.name == settings_.camera; });
    if (found == cameras.end())
      throw DeviceError(settings_.camera, fmt::format("take {} has no camera of this name", settings_.device));
    if (take_->frame_set_count() == 0)
      throw DeviceError(settings_.camera, fmt::format("take {} holds no frame", settings_.device));
    camera_ = static_cast<std::size_t>(found - cameras.begin());
  } catch (const DeviceError&) {
    state_ = SourceState::closed;
    throw;
  } catch (const std::exception& error) {
    state_ = SourceState::closed;
    throw DeviceError(settings_.camera, fmt::format("cannot be replayed: {}", error.what()));
  }
}

void ReplaySource::arm() {
  if (settings_.trigger == TriggerMode::action || settings_.trigger == TriggerMode::line)
    throw DeviceError(settings_.camera, fmt::format("a replayed take cannot be triggered by {}: set trigger.mode to "
                                                    "freerun or software",
                                                    to_string(settings_.trigger)));
  const auto& camera = take_->info().cameras[camera_];
  if ((settings_.width != 0 && settings_.width != camera.width) ||
      (settings_.height != 0 && settings_.height != camera.height))
    throw DeviceError(settings_.camera,
                      fmt::format("take {} has {} x {} pixels of it, the rig file asks for {} x {}", settings_.device,
                                  camera.width, camera.height, settings_.width, settings_.height));
  become(SourceState::armed);
}

void ReplaySource::start(FrameSink frames, IncompleteSink) {
  become(SourceState::streaming);
  sink_ = std::move(frames);
  triggers_ = 0;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), settings_.camera.substr(0, 15).c_str());
    settings_.trigger == TriggerMode::freerun ? play_on_grid(stop) : play_on_triggers(stop);
  });
}

void ReplaySource::play_on_grid(const std::stop_token& stop) {
  const auto period = period_of(settings_.frame_rate_hz.value_or(kUsualRate));
  TriggerGrid grid = grid_from(RigClock::now(), period);
  auto exposure = static_cast<std::uint64_t>(grid.start.time_since_epoch() / period);
  for (std::uint64_t k = 0; !stop.stop_requested(); ++k, ++exposure) {
    const auto moment = grid.time_of(k);
    std::unique_lock lock(mutex_);
    triggered_.wait_for(lock, stop, std::max<std::chrono::nanoseconds>(moment - RigClock::now(), {}),
                        [] { return false; });
    lock.unlock();
    if (!stop.stop_requested()) send(exposure, moment);
  }
}

void ReplaySource::play_on_triggers(const std::stop_token& stop) {
  for (std::uint64_t exposure = 0;; ++exposure) {
    std::unique_lock lock(mutex_);
    if (!triggered_.wait(lock, stop, [this] { return triggers_ > 0; })) return;
    --triggers_;
    lock.unlock();
    send(exposure, RigClock::now());
  }
}

void ReplaySource::send(std::uint64_t exposure, Timestamp moment) {
  const auto index = static_cast<std::size_t>(exposure % take_->frame_set_count());
  auto slot = take_->read(index, camera_);
  if (!slot.frame) return;
  Frame& frame = *slot.frame;
  frame.exposure_start = moment + (frame.exposure_start - take_->time_of(index));
  frame.trigger = 0;
  frame.id = exposure + 1;
  ++frames_;
  sink_(std::move(frame));
}

void ReplaySource::software_trigger() {
  if (state_ != SourceState::streaming) throw InvalidInput(settings_.camera + ": is not streaming");
  const std::lock_guard lock(mutex_);
  ++triggers_;
  triggered_.notify_one();
}

void ReplaySource::stop() {
  become(SourceState::armed);
  thread_ = {};
  sink_ = {};
}

void ReplaySource::close() noexcept {
  thread_ = {};
  sink_ = {};
  state_ = SourceState::closed;
}

SourceDescription ReplaySource::description() const {
  SourceDescription description{.vendor = "Rotunda", .model = "replay", .serial = "", .address = settings_.device};
  if (!take_) return description;
  const auto& camera = take_->info().cameras[camera_];
  description.width = camera.width;
  description.height = camera.height;
  description.format = camera.format;
  description.ycbcr = camera.ycbcr;
  return description;
}

}  // namespace

std::unique_ptr<Source> make_replay_source(const SourceSettings& settings) {
  return std::make_unique<ReplaySource>(settings);
}

std::vector<DiscoveredCamera> discover_replay_cameras() {
  return {};
}

}  // namespace rotunda::capture
