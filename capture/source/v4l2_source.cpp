#include "capture/source/v4l2_source.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "capture/base/timely_thread.h"
#include "capture/source/pixel_pool.h"
#include "capture/source/v4l2_camera.h"
#include "capture/ycbcr_picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookForStop = 100ms;  // at the latest; stopping the stream wakes the thread at once
// A camera that runs by itself and is silent this long, or for so many of its periods, hangs: opening it anew helps.
constexpr auto kLongestSilence = 3s;
constexpr int kPeriodsOfSilence = 10;
// A time stamp further than this from the moment of arrival is of another clock.
constexpr auto kMostAhead = 1s;
constexpr auto kMostBehind = 10s;
constexpr int kErrorsInARow = 5;              // of the driver's before the camera counts as lost
constexpr std::uint32_t kMostDropped = 1000;  // a greater gap in its numbers: the driver counts anew

class V4l2Source final : public Source {
 public:
  V4l2Source(SourceSettings settings, V4l2System& system) : settings_(std::move(settings)), system_(system) {}
  V4l2Source(const V4l2Source&) = delete;
  V4l2Source& operator=(const V4l2Source&) = delete;
  ~V4l2Source() override { close(); }

  void open() override;
  void arm() override;
  void start(FrameSink frames, IncompleteSink incomplete) override;
  void stop() override;
  void software_trigger() override;
  void close() noexcept override;

  SourceState state() const override { return state_; }
  SourceStats stats() const override;
  SourceDescription description() const override;

 private:
  void require(SourceState needed, const char* verb) const;
  void become(SourceState next);
  void set_sinks(FrameSink frames, IncompleteSink incomplete);
  void end_stream() noexcept;

  void stream(std::stop_token stop) noexcept;
  bool serve_once(int& errors);  // false: the camera is lost
  bool silent_too_long() const;
  void take(const V4l2Frame& frame);
  void count(std::uint32_t sequence);
  std::string flaw_of(const V4l2Frame& frame) const;
  Timestamp exposure_start(const V4l2Frame& frame);
  std::optional<Image> copied(const V4l2Frame& frame) const;
  void tell_incomplete(const V4l2Frame& frame, HoleReason because, std::string flaw);
  void warn_of_time_stamps();

  const SourceSettings settings_;
  V4l2System& system_;
  std::atomic<SourceState> state_{SourceState::closed};
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> incomplete_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::uint64_t> underruns_{0};

  mutable std::mutex mutex_;  // guards what description() shows
  SourceDescription description_;

  std::mutex sink_mutex_;  // held while a sink is called, so that stop() can promise silence
  FrameSink frame_sink_;
  IncompleteSink incomplete_sink_;

  std::unique_ptr<V4l2Camera> camera_;
  std::shared_ptr<PixelPool> pool_;
  // Of the stream thread:
  SourceDescription agreed_;
  std::optional<std::uint32_t> last_sequence_;
  std::optional<std::uint64_t> exposures_;  // Frame::id of the newest
  std::chrono::nanoseconds last_frame_{};   // CLOCK_MONOTONIC
  bool warned_of_time_stamps_ = false;
  std::jthread thread_;  // last: it uses the rest
};

void V4l2Source::require(SourceState needed, const char* verb) const {
  const SourceState now = state_;
  if (now == needed) return;
  if (now == SourceState::lost)
    throw DeviceError(settings_.camera, settings_.device + " was lost; it must be closed and opened again");
  throw InvalidInput(fmt::format("{}: a camera that is {} cannot be {}", settings_.camera, to_string(now), verb));
}

// The stream thread may find the camera lost in between: then that stays.
void V4l2Source::become(SourceState next) {
  SourceState now = state_;
  do {
    if (now == SourceState::lost) require(next, "");
    checked_transition(now, next, settings_.camera);
  } while (!state_.compare_exchange_strong(now, next));
}

void V4l2Source::open() {
  require(SourceState::closed, "opened");
  camera_ = std::make_unique<V4l2Camera>(system_, settings_);
  become(SourceState::open);
}

void V4l2Source::arm() {
  require(SourceState::open, "armed");
  if (settings_.trigger == TriggerMode::software || settings_.trigger == TriggerMode::action)
    throw DeviceError(settings_.camera, fmt::format("a V4L2 camera knows no {} triggers; set trigger.mode to freerun, "
                                                    "or to line if a cable triggers it",
                                                    to_string(settings_.trigger)));
  agreed_ = camera_->configure();
  camera_->map_buffers();
  const auto bytes = settings_.format == PixelFormat::mjpeg
                         ? camera_->buffer_bytes()
                         : image_bytes(agreed_.width, agreed_.height, agreed_.format);
  pool_ = std::make_shared<PixelPool>(bytes, static_cast<std::size_t>(std::max(settings_.buffers_at_most, 1)));
  {
    const std::lock_guard lock(mutex_);
    description_ = agreed_;
  }
  become(SourceState::armed);
}

void V4l2Source::set_sinks(FrameSink frames, IncompleteSink incomplete) {
  const std::lock_guard lock(sink_mutex_);
  frame_sink_ = std::move(frames);
  incomplete_sink_ = std::move(incomplete);
}

void V4l2Source::start(FrameSink frames, IncompleteSink incomplete) {
  require(SourceState::armed, "started");
  set_sinks(std::move(frames), std::move(incomplete));
  last_sequence_.reset();
  exposures_.reset();
  camera_->start();
  last_frame_ = system_.monotonic_now();
  become(SourceState::streaming);
  thread_ = std::jthread([this](std::stop_token stop) { stream(std::move(stop)); });
}

void V4l2Source::end_stream() noexcept {
  thread_.request_stop();
  if (camera_) camera_->stop();  // wakes the thread
  if (thread_.joinable()) thread_.join();
  if (camera_) camera_->stop();  // takes back what the thread handed in meanwhile
}

void V4l2Source::stop() {
  require(SourceState::streaming, "stopped");
  set_sinks({}, {});
  end_stream();
  become(SourceState::armed);
}

void V4l2Source::software_trigger() {
  require(SourceState::streaming, "triggered");
  throw DeviceError(settings_.camera, "a V4L2 camera cannot be triggered by software; set trigger.mode to freerun");
}

void V4l2Source::close() noexcept {
  set_sinks({}, {});
  end_stream();
  camera_.reset();
  pool_.reset();
  state_ = SourceState::closed;
}

void V4l2Source::stream(std::stop_token stop) noexcept {
  pthread_setname_np(pthread_self(), settings_.camera.substr(0, 15).c_str());
  make_this_thread_timely();
  int errors = 0;
  while (!stop.stop_requested()) {
    const bool ready = camera_->wait(kLookForStop);
    if (stop.stop_requested()) return;
    if ((!ready && !silent_too_long()) || (ready && serve_once(errors))) continue;
    state_ = SourceState::lost;
    return;
  }
}

// Ready without a frame: the node reports trouble that no frame will end.
bool V4l2Source::serve_once(int& errors) {
  V4l2Frame frame;
  switch (camera_->next(frame)) {
    case V4l2Answer::frame:
      errors = 0;
      last_frame_ = system_.monotonic_now();
      take(frame);
      return camera_->give_back(frame.buffer);
    case V4l2Answer::error:
      ++incomplete_;
      return ++errors < kErrorsInARow;
    case V4l2Answer::nothing:
      return ++errors < kErrorsInARow;
    case V4l2Answer::gone:
      break;
  }
  return false;
}

bool V4l2Source::silent_too_long() const {
  if (settings_.trigger != TriggerMode::freerun) return false;
  const double period = settings_.frame_rate_hz ? 1.0 / *settings_.frame_rate_hz : 0.0;
  const std::chrono::duration<double> patience(kPeriodsOfSilence * period);
  return system_.monotonic_now() - last_frame_ > std::max<std::chrono::duration<double>>(kLongestSilence, patience);
}

void V4l2Source::take(const V4l2Frame& frame) {
  count(frame.sequence);
  if (auto flaw = flaw_of(frame); !flaw.empty()) return tell_incomplete(frame, HoleReason::damaged, std::move(flaw));
  auto image = copied(frame);
  if (!image) {
    ++underruns_;
    return tell_incomplete(frame, HoleReason::packets_lost, "no memory free: readers hold all of it");
  }
  Frame ours{settings_.camera, 0, exposures_, exposure_start(frame), agreed_.exposure, std::move(*image)};
  ++frames_;
  const std::lock_guard lock(sink_mutex_);
  if (frame_sink_) frame_sink_(std::move(ours));
}

// The driver's numbers wrap at 2^32; some drivers do not count at all, or begin anew: then there is no count of
// exposures until it goes on.
void V4l2Source::count(std::uint32_t sequence) {
  const auto step = last_sequence_ ? sequence - *last_sequence_ : 1U;
  last_sequence_ = sequence;
  if (step == 0 || step > kMostDropped) {
    exposures_.reset();
    return;
  }
  dropped_ += step - 1;
  exposures_ = exposures_.value_or(sequence) + step;
}

std::string V4l2Source::flaw_of(const V4l2Frame& frame) const {
  if (frame.damaged) return "its driver marked it as damaged";
  if (settings_.format == PixelFormat::mjpeg) return jpeg_flaw(frame.bytes, agreed_.width, agreed_.height);
  const std::size_t needed = bytes_needed(camera_->layout());
  if (frame.bytes.size() >= needed) return "";
  return fmt::format("cut short: {} of {} bytes", frame.bytes.size(), needed);
}

Timestamp V4l2Source::exposure_start(const V4l2Frame& frame) {
  const auto now = system_.monotonic_now();
  const bool believable = frame.time_is_monotonic && frame.time <= now + kMostAhead && frame.time >= now - kMostBehind;
  if (!believable) warn_of_time_stamps();
  const auto stamp = rig_time_of(system_, believable ? frame.time : now);
  return believable && frame.time_is_start ? stamp : stamp - agreed_.exposure;
}

void V4l2Source::warn_of_time_stamps() {
  if (std::exchange(warned_of_time_stamps_, true)) return;
  const std::lock_guard lock(mutex_);
  description_.warnings.emplace_back(
      "its driver's time stamps are not of CLOCK_MONOTONIC: the moments when frames arrive stand for them, which are "
      "late by the time a frame takes to come");
}

std::optional<Image> V4l2Source::copied(const V4l2Frame& frame) const {
  auto piece = pool_->take();
  if (!piece) return std::nullopt;
  Image image{.width = agreed_.width,
              .height = agreed_.height,
              .format = agreed_.format,
              .pixels = nullptr,
              .ycbcr = agreed_.ycbcr};
  if (agreed_.format == PixelFormat::mjpeg) {
    image.jpeg_bytes = std::min(frame.bytes.size(), pool_->piece_bytes());
    std::memcpy(piece.get(), frame.bytes.data(), image.jpeg_bytes);
  } else {
    copy_image(camera_->layout(), frame.bytes, piece.get());
  }
  image.pixels = std::move(piece);
  return image;
}

void V4l2Source::tell_incomplete(const V4l2Frame& frame, HoleReason because, std::string flaw) {
  ++incomplete_;
  const std::lock_guard lock(sink_mutex_);
  if (incomplete_sink_) incomplete_sink_({settings_.camera, exposure_start(frame), because, std::move(flaw)});
}

SourceStats V4l2Source::stats() const {
  SourceStats stats;
  stats.frames = frames_;
  stats.incomplete = incomplete_;
  stats.dropped = dropped_;
  stats.underruns = underruns_;
  return stats;
}

SourceDescription V4l2Source::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

}  // namespace

std::unique_ptr<Source> make_v4l2_source(const SourceSettings& settings) {
  return make_v4l2_source(settings, kernel_v4l2());
}

std::unique_ptr<Source> make_v4l2_source(const SourceSettings& settings, V4l2System& system) {
  return std::make_unique<V4l2Source>(settings, system);
}

std::vector<DiscoveredCamera> discover_v4l2_cameras() {
  return discover_v4l2_cameras(kernel_v4l2());
}

}  // namespace rotunda::capture
