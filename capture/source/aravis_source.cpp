#include "capture/source/aravis_source.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "capture/base/timely_thread.h"
#include "capture/source/aravis_camera.h"
#include "capture/source/aravis_features.h"
#include "capture/source/aravis_frames.h"
#include "capture/source/aravis_opening.h"
#include "capture/source/aravis_stream.h"
#include "capture/source/buffer_pool.h"
#include "capture/source/gvcp_memory.h"
#include "capture/source/resend_budget.h"
#include "capture/source/stream_socket.h"

namespace rotunda::capture {

namespace {

constexpr int least_packet = 576;  // bytes, that GigE Vision asks of every link

class AravisSource;

// Between a stream, which may outlive its source when the camera is gone, and the source.
struct StreamTie {
  std::mutex mutex;
  AravisSource* source = nullptr;  // nobody: what still comes is let go
};

class AravisSource final : public Source {
 public:
  explicit AravisSource(SourceSettings settings) : settings_(std::move(settings)), frames_(settings_.camera) {}
  AravisSource(const AravisSource&) = delete;
  AravisSource& operator=(const AravisSource&) = delete;
  ~AravisSource() override { close(); }

  void open() override;
  void arm() override;
  void pace(const StreamPacing& pacing) override;
  void start(FrameSink frames, IncompleteSink incomplete) override;
  void stop() override;
  void software_trigger() override;
  SourceHealth look() override;
  bool show_light(bool on) override;
  void close() noexcept override;
  std::optional<std::string> heal() override;

  SourceState state() const override { return state_; }
  SourceStats stats() const override;
  SourceDescription description() const override;

 private:
  static void on_control_lost(ArvDevice*, gpointer self);
  static void on_stream(void* tie, ArvStreamCallbackType type, ArvBuffer* buffer) noexcept;

  void require(SourceState needed, const char* verb) const;  // throws unless so
  void become(SourceState next);
  void mind_loss(const std::function<void()>& call);
  void hear_stream(ArvStreamCallbackType type, const ArvBuffer* done);
  void require_an_answer();
  void keep_resend_budget(SourceHealth& health);
  void cure_socket_buffer(ArvStream* stream);
  GRef<ArvStream> create_clean_stream();
  void make_stream();
  GRef<ArvStream> take_stream() noexcept;
  SourceHealth ask_health();

  const SourceSettings settings_;
  std::atomic<SourceState> state_{SourceState::closed};
  AravisFrames frames_;

  mutable std::mutex mutex_;  // guards what stats() and description() show
  SourceDescription description_;
  StreamChannel channel_;
  int socket_buffer_bytes_ = 0;

  std::size_t frame_packets_ = 1;  // about
  StreamDeafness deafness_;

  GRef<ArvCamera> camera_;
  std::optional<AravisFeatures> features_;
  std::optional<ClockWatch> clock_;
  std::optional<ResendBudget> resends_;
  int resend_mode_ = 0;  // ArvGvStreamPacketResend, as Aravis chose it for this camera
  GRef<ArvStream> stream_;
  std::shared_ptr<StreamTie> tie_;  // of that stream
  std::shared_ptr<BufferPool> pool_;
  std::uint64_t frames_at_last_look_ = 0;
};

void AravisSource::require(SourceState needed, const char* verb) const {
  const SourceState now = state_;
  if (now == needed) return;
  if (now == SourceState::lost)
    throw DeviceError(settings_.camera, settings_.device + " was lost; it must be closed and opened again");
  throw InvalidInput(fmt::format("{}: a camera that is {} cannot be {}", settings_.camera, to_string(now), verb));
}

// The heartbeat thread may tell of the loss in between: then that stays.
void AravisSource::become(SourceState next) {
  SourceState now = state_;
  do {
    if (now == SourceState::lost) require(next, "");
    checked_transition(now, next, settings_.camera);
  } while (!state_.compare_exchange_strong(now, next));
}

// A camera that does not answer is lost at once, not when Aravis gives up its heartbeat.
void AravisSource::mind_loss(const std::function<void()>& call) {
  try {
    call();
  } catch (const CameraGone&) {
    state_ = SourceState::lost;
    throw;
  }
}

void AravisSource::open() {
  require(SourceState::closed, "opened");
  camera_ = open_camera(settings_);
  features_.emplace(camera_.get(), settings_.camera);
  become(SourceState::open);
  g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(on_control_lost), this);
}

// On Aravis' heartbeat thread, six seconds or so after a GigE Vision camera has gone; on any thread when a USB3 Vision
// camera is pulled out.
void AravisSource::on_control_lost(ArvDevice*, gpointer self) {
  static_cast<AravisSource*>(self)->state_ = SourceState::lost;
}

void AravisSource::arm() {
  require(SourceState::open, "armed");
  SourceDescription description = configure_camera(camera_.get(), settings_);
  const StreamChannel channel = configure_stream_channel(camera_.get(), settings_);
  frames_.expect(description, arv_camera_get_pixel_format(camera_.get(), nullptr),
                 arv_camera_is_uv_device(camera_.get()));
  {
    const std::lock_guard lock(mutex_);
    description_ = std::move(description);
    description_.link = channel.link;
    description_.link_bits_per_second = channel.link_bits_per_second;
    channel_ = channel;
  }
  make_stream();
  clock_.emplace(*features_, settings_.clock);
  clock_->begin();
  ask_health();
  become(SourceState::armed);
}

// Where a link is too busy for a packet socket to begin clean, packets come by the ordinary one.
GRef<ArvStream> AravisSource::create_clean_stream() {
  constexpr int kTries = 5;
  const auto create = [&] { return create_stream(camera_.get(), settings_, on_stream, tie_.get()); };
  for (int i = 0; i < kTries; ++i)
    if (auto stream = create(); began_clean(stream.get(), channel_.packet_socket)) return stream;
  forgo_packet_socket(camera_.get());
  {
    const std::lock_guard lock(mutex_);
    channel_.packet_socket = false;
  }
  return create();
}

void AravisSource::make_stream() {
  const std::size_t payload = payload_bytes(camera_.get(), settings_, description_);
  tie_ = std::make_shared<StreamTie>();
  tie_->source = this;
  GRef<ArvStream> stream = create_clean_stream();
  tune_stream(stream.get(), settings_.frame_rate_hz);
  if (ARV_IS_GV_STREAM(stream.get())) {
    cure_socket_buffer(stream.get());
    accept_only_from(arv_gv_stream_get_port(ARV_GV_STREAM(stream.get())), description_.address);
    g_object_get(stream.get(), "packet-resend", &resend_mode_, nullptr);
    resends_.emplace(settings_.resend_budget);
  }
  pool_ = std::make_shared<BufferPool>(stream.get(), payload, settings_.buffers, settings_.buffers_at_most);
  {
    const std::lock_guard lock(mutex_);
    stream_ = std::move(stream);
  }
  pool_->top_up();
  frame_packets_ = payload / static_cast<std::size_t>(std::max(channel_.packet_size, least_packet)) + 1;
  deafness_ = {};
}

// Nothing of it is heard any more. Its end joins its thread, and asks the camera to stop.
GRef<ArvStream> AravisSource::take_stream() noexcept {
  if (tie_) {
    const std::lock_guard lock(tie_->mutex);
    tie_->source = nullptr;
  }
  if (pool_) pool_->close();
  pool_.reset();
  const std::lock_guard lock(mutex_);
  socket_buffer_bytes_ = 0;
  return std::move(stream_);
}

std::optional<std::string> AravisSource::heal() {
  if (state_ != SourceState::streaming || !deafness_.look(stream_.get(), frames_.heard(), frame_packets_))
    return std::nullopt;
  stop_acquisition(camera_.get(), settings_);
  take_stream().reset();
  frames_.begin_count();
  make_stream();
  start_acquisition(camera_.get(), settings_);
  return fmt::format(
      "{}: {} sent packets of which no frame came, as when its block ids go back; its stream was made anew. If it "
      "happens again, look for a bad cable or switch",
      settings_.camera, settings_.device);
}

SourceHealth AravisSource::ask_health() {
  SourceHealth health{.clock = clock_->look(), .temperature_c = std::nullopt};
  keep_resend_budget(health);
  if (features_->has("DeviceTemperature")) health.temperature_c = read_number(*features_, "DeviceTemperature");
  if (health.clock.kind != "none")
    frames_.follow_clock(clock_->map());
  else if (state_ != SourceState::streaming)
    frames_.guess_clock();
  return health;
}

// Paused from one look to the next while a camera needs more than its share.
void AravisSource::keep_resend_budget(SourceHealth& health) {
  if (!resends_) return;
  constexpr double kWorthTelling = 0.005;
  const auto now = stats();
  const bool on = resends_->look((now.frames + now.incomplete) * frame_packets_, now.resend_requests);
  g_object_set(stream_.get(), "packet-resend", on ? resend_mode_ : ARV_GV_STREAM_PACKET_RESEND_NEVER, nullptr);
  health.asked_again = resends_->share();
  if (health.asked_again >= kWorthTelling)
    health.problem = resends_told(health.asked_again, on, settings_.resend_budget);
}

// Aravis takes 2.5 s to find out, and as long again while its heartbeat does: a camera that sends nothing is asked
// first whether it is there at all.
void AravisSource::require_an_answer() {
  const auto frames = frames_.heard();
  const bool quiet = std::exchange(frames_at_last_look_, frames) == frames;
  if (!quiet || !ARV_IS_GV_STREAM(stream_.get()) || answers_gvcp(description_.address)) return;
  state_ = SourceState::lost;
  throw CameraGone(settings_.camera, settings_.device + " no longer answers; check its cable and power");
}

// A camera may refuse to tell something and work all the same; one that does not answer at all is lost.
SourceHealth AravisSource::look() {
  if (state_ != SourceState::streaming) require(SourceState::armed, "looked at");
  require_an_answer();
  try {
    return ask_health();
  } catch (const DeviceError& error) {
    if (features_->is_gone()) {
      state_ = SourceState::lost;
      throw CameraGone(settings_.camera, settings_.device + " no longer answers; check its cable and power");
    }
    SourceHealth health;
    health.clock.problem = error.what();
    return health;
  }
}

void AravisSource::pace(const StreamPacing& pacing) {
  require(SourceState::armed, "paced");
  mind_loss([&] { configure_pacing(camera_.get(), settings_, pacing); });
}

void AravisSource::cure_socket_buffer(ArvStream* stream) {
  const int granted = set_receive_buffer(arv_gv_stream_get_port(ARV_GV_STREAM(stream)), wanted_socket_buffer_bytes);
  const std::lock_guard lock(mutex_);
  socket_buffer_bytes_ = granted;
  if (granted < wanted_socket_buffer_bytes)
    description_.warnings.push_back(
        fmt::format("the stream's socket buffer is {} bytes where {} were asked: packets may be lost; run sysctl -w "
                    "net.core.rmem_max={}",
                    granted, wanted_socket_buffer_bytes, wanted_socket_buffer_bytes));
}

void AravisSource::start(FrameSink frames, IncompleteSink incomplete) {
  require(SourceState::armed, "started");
  frames_.begin_count();
  frames_.set_sinks(std::move(frames), std::move(incomplete));  // before the camera starts: the first frame counts
  mind_loss([&] { start_acquisition(camera_.get(), settings_); });
  become(SourceState::streaming);
}

void AravisSource::stop() {
  require(SourceState::streaming, "stopped");
  frames_.set_sinks({}, {});
  mind_loss([&] { stop_acquisition(camera_.get(), settings_); });
  become(SourceState::armed);
}

void AravisSource::software_trigger() {
  require(SourceState::streaming, "triggered");
  mind_loss([&] { fire_software_trigger(camera_.get(), settings_); });
}

bool AravisSource::show_light(bool on) {
  return camera_ && set_indicator_light(camera_.get(), on);
}

void AravisSource::close() noexcept {
  frames_.set_sinks({}, {});
  if (camera_ && state_ == SourceState::streaming) arv_camera_stop_acquisition(camera_.get(), nullptr);
  auto stream = take_stream();
  resends_.reset();
  clock_.reset();
  features_.reset();
  if (camera_) {
    g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), this);
    close_camera(std::move(camera_), std::move(stream), tie_, state_ == SourceState::lost);
  }
  state_ = SourceState::closed;
}

void AravisSource::on_stream(void* data, ArvStreamCallbackType type, ArvBuffer* buffer) noexcept {
  auto& tie = *static_cast<StreamTie*>(data);
  const std::lock_guard lock(tie.mutex);
  if (tie.source) tie.source->hear_stream(type, buffer);
}

// On the stream's thread.
void AravisSource::hear_stream(ArvStreamCallbackType type, const ArvBuffer* done) {
  if (type == ARV_STREAM_CALLBACK_TYPE_INIT) {
    pthread_setname_np(pthread_self(), settings_.camera.substr(0, 15).c_str());
    make_this_thread_timely();
  } else if (type == ARV_STREAM_CALLBACK_TYPE_BUFFER_DONE && stream_) {
    if (ArvBuffer* buffer = pop_done(stream_.get(), done, *pool_)) frames_.hand_on(buffer, *pool_);
    pool_->top_up();
  }
}

SourceStats AravisSource::stats() const {
  const std::lock_guard lock(mutex_);
  SourceStats stats;
  stats.frames = frames_.whole();
  stats.incomplete = frames_.incomplete();
  stats.socket_buffer_bytes = socket_buffer_bytes_;
  stats.packet_size = channel_.packet_size;
  stats.packet_socket = channel_.packet_socket;
  if (!stream_) return stats;
  read_counters(stream_.get(), stats);
  return stats;
}

SourceDescription AravisSource::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

}  // namespace

std::unique_ptr<Source> make_aravis_source(const SourceSettings& settings) {
  return std::make_unique<AravisSource>(settings);
}

}  // namespace rotunda::capture
