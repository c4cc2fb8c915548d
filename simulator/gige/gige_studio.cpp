#include "simulator/gige/gige_studio.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "config/errors.h"
#include "simulator/gige/camera_stream.h"
#include "simulator/gige/gige_device.h"
#include "simulator/gige/region.h"
#include "simulator/gige/studio_sockets.h"
#include "simulator/gige/trigger_box.h"

namespace rotunda::simulator {
namespace {

using capture::RigClock;
using capture::Timestamp;
using namespace std::chrono_literals;

constexpr auto kUptime = 1h;          // of the cameras when the studio opens: their clocks have settled
constexpr auto kLongestWait = 100ms;  // both threads look at the clock at least this often

void check(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
}

CameraStream::Link link_of(const GigeFaults& faults) {
  if (faults.silent) return CameraStream::Link::silent;
  return faults.rebooting ? CameraStream::Link::rebooting : CameraStream::Link::up;
}

struct EpollHandle {
  int fd = epoll_create1(EPOLL_CLOEXEC);
  EpollHandle() = default;
  EpollHandle(const EpollHandle&) = delete;
  EpollHandle& operator=(const EpollHandle&) = delete;
  ~EpollHandle() { close(fd); }
};

struct Camera {
  Camera(const GigeCameraOptions& options, bool is_clock_master)
      : name(options.name),
        sensor{static_cast<std::uint32_t>(options.width), static_cast<std::uint32_t>(options.height)},
        picture_bytes(simulator::picture_bytes(pixel_code(options.format), sensor.width, sensor.height)),
        control(control_socket(options)),
        stream(stream_socket(options)),
        device(options, is_clock_master ? PtpStatus::master : PtpStatus::slave, stream.port(),
               RigClock::now() - kUptime) {}

  std::string name;
  Region sensor;
  std::size_t picture_bytes;
  UdpSocket control, stream;
  // Shared by both threads, under the studio's mutex:
  GigeDevice device;
  StreamCounts sent;
  std::uint64_t missing_pictures = 0;
};

// `re_exposed`: the memory of `picture`, unless that is lent.
GvspFrame gvsp_frame(const DueFrame& due, std::span<const std::uint8_t> picture, std::vector<std::uint8_t> re_exposed,
                     const Region& sensor) {
  GvspFrame frame{.block = due.block,
                  .extended_ids = due.extended_ids,
                  .exposure_start = due.stamp,
                  .pixel_code = due.pixel_code,
                  .width = due.width,
                  .height = due.height,
                  .offset_x = due.offset_x,
                  .offset_y = due.offset_y,
                  .packet_size = due.packet_size,
                  .pixels = picture,
                  .own_pixels = {},
                  .chunks = due.chunks};
  const Region region{due.width, due.height, due.offset_x, due.offset_y};
  if (region == sensor) {
    frame.own_pixels = std::move(re_exposed);  // what `picture` shows, if there is any
    return frame;
  }
  frame.own_pixels = read_out(picture, sensor.width, bits_per_pixel(due.pixel_code), region);
  frame.pixels = frame.own_pixels;
  return frame;
}

// What the sender takes along when it leaves the mutex.
struct Errands {
  std::vector<DueFrame> frames;
  std::vector<ResendCommand> resends;
  std::vector<TestPacket> test_packets;
  CameraStream::Link link = CameraStream::Link::up;
};

}  // namespace

struct GigeStudio::Impl {
  Impl(const std::vector<GigeCameraOptions>& options, PictureAt picture, const GigeStudioOptions& studio)
      : picture_at(std::move(picture)), on_exposure(studio.on_exposure), re_expose(studio.re_expose) {
    check_distinct(options);
    cameras.reserve(options.size());
    for (const auto& camera : options) {
      cameras.emplace_back(camera, cameras.empty());
      streams.emplace_back(streams.size(), cameras.back().stream.fd(), studio.link_bits_per_second);
    }
    missing_pictures.resize(cameras.size());
    broadcasts = broadcast_sockets();
    check(poll.fd, "epoll_create1");
    for (std::size_t i = 0; i < cameras.size(); ++i) watch(cameras[i].control, i);
    for (std::size_t i = 0; i < broadcasts.size(); ++i) watch(broadcasts[i], cameras.size() + i);
    if (studio.trigger_box_port) {
      trigger_box.emplace(trigger_box_socket(*studio.trigger_box_port));
      watch(*trigger_box, cameras.size() + broadcasts.size());
    }
  }

  void watch(const UdpSocket& socket, std::size_t number) const {
    epoll_event event{.events = EPOLLIN, .data = {.u64 = number}};
    check(epoll_ctl(poll.fd, EPOLL_CTL_ADD, socket.fd(), &event), "epoll_ctl");
  }

  void control_loop();
  void drain(UdpSocket& socket, std::span<Camera> hearers);
  void drain_trigger_box();
  void hand_to(Camera& camera, std::span<const std::uint8_t> datagram, const UdpSocket::Received& received);
  std::chrono::nanoseconds send_late_acknowledgements(Timestamp now);
  std::optional<Timestamp> next_due() const;
  void wake_sender_if_needed(std::optional<Timestamp> due_before);

  void sender_loop();
  std::vector<Errands> collect(Timestamp now);
  void run(std::size_t camera, const Errands& errands);
  void send_frame(std::size_t camera, const DueFrame& frame);
  void send_bursts(const std::vector<Errands>& errands);
  void publish_and_wait();

  GigeDevice& device(std::size_t camera);  // throws InvalidInput for one that is not there

  PictureAt picture_at;
  OnExposure on_exposure;
  ReExpose re_expose;
  std::vector<UdpSocket> broadcasts;
  std::optional<UdpSocket> trigger_box;
  EpollHandle poll;  // events carry the camera's number; broadcasts follow the cameras, then the trigger box
  mutable std::mutex mutex;
  std::condition_variable wake;
  std::vector<Camera> cameras;
  bool sender_has_work = false, stopping = false;  // under the mutex
  // The sender's own:
  std::vector<CameraStream> streams;
  std::vector<std::uint64_t> missing_pictures;
  std::array<std::uint8_t, 2048> buffer{};  // the control thread's own
  std::atomic<bool> control_stopping = false;
  std::jthread control, sender;
};

// --- control thread ---------------------------------------------------------------------------------------------

void GigeStudio::Impl::control_loop() {
  prctl(PR_SET_NAME, "gige-control");
  std::array<epoll_event, 16> events{};
  std::chrono::nanoseconds wait = kLongestWait;
  while (!control_stopping) {
    const int ready = epoll_wait(poll.fd, events.data(), static_cast<int>(events.size()),
                                 static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(wait).count()));
    const Timestamp now = RigClock::now();
    for (int i = 0; i < ready; ++i) {
      const std::size_t number = events[static_cast<std::size_t>(i)].data.u64;
      if (number < cameras.size())
        drain(cameras[number].control, std::span{cameras}.subspan(number, 1));
      else if (number == cameras.size() + broadcasts.size())
        drain_trigger_box();
      else
        drain(broadcasts[number - cameras.size()], cameras);
    }
    const std::scoped_lock lock(mutex);
    wait = send_late_acknowledgements(now);
    for (auto& camera : cameras) {
      camera.device.advance(now);
      if (ready < static_cast<int>(events.size())) camera.device.check_heartbeat(now);
    }
  }
}

void GigeStudio::Impl::drain(UdpSocket& socket, std::span<Camera> hearers) {
  while (const auto received = socket.receive(buffer)) {
    const std::span datagram = std::span{buffer}.first(std::min(received->bytes, buffer.size()));
    const std::scoped_lock lock(mutex);
    const auto due_before = next_due();
    for (auto& camera : hearers) hand_to(camera, datagram, *received);
    wake_sender_if_needed(due_before);
  }
}

void GigeStudio::Impl::drain_trigger_box() {
  while (const auto received = trigger_box->receive(buffer)) {
    const auto level = parse_line(std::span{buffer}.first(std::min(received->bytes, buffer.size())));
    if (!level) continue;
    const std::scoped_lock lock(mutex);
    for (auto& camera : cameras) camera.device.set_line0(level->high, level->at.value_or(received->at));
    sender_has_work = true;
    wake.notify_one();
  }
}

void GigeStudio::Impl::hand_to(Camera& camera, std::span<const std::uint8_t> datagram,
                               const UdpSocket::Received& received) {
  if (const auto acknowledgement = camera.device.handle(datagram, received.from, received.at))
    camera.control.send(*acknowledgement, received.from);
}

// Those whose time has come; how long epoll may wait for the next.
std::chrono::nanoseconds GigeStudio::Impl::send_late_acknowledgements(Timestamp now) {
  std::chrono::nanoseconds wait = kLongestWait;
  for (auto& camera : cameras) {
    while (const auto late = camera.device.take_late_acknowledgement(now))
      camera.control.send(late->datagram, late->to);
    if (const auto next = camera.device.next_late_acknowledgement()) wait = std::min(wait, *next - now);
  }
  return wait;
}

std::optional<Timestamp> GigeStudio::Impl::next_due() const {
  std::optional<Timestamp> earliest;
  for (const auto& camera : cameras) {
    const auto due = camera.device.next_due();
    if (due && (!earliest || *due < *earliest)) earliest = due;
  }
  return earliest;
}

void GigeStudio::Impl::wake_sender_if_needed(std::optional<Timestamp> due_before) {
  const bool has_errand =
      std::any_of(cameras.begin(), cameras.end(), [](const Camera& camera) { return camera.device.has_errand(); });
  if (!has_errand && next_due() == due_before) return;
  sender_has_work = true;
  wake.notify_one();
}

// --- sender thread ----------------------------------------------------------------------------------------------

void GigeStudio::Impl::sender_loop() {
  prctl(PR_SET_NAME, "gige-sender");
  prctl(PR_SET_TIMERSLACK, 1);
  for (;;) {
    const auto errands = collect(RigClock::now());
    if (errands.empty()) return;
    for (std::size_t i = 0; i < errands.size(); ++i) run(i, errands[i]);
    send_bursts(errands);
    publish_and_wait();
  }
}

// Empty when the studio stops.
std::vector<Errands> GigeStudio::Impl::collect(Timestamp now) {
  const std::scoped_lock lock(mutex);
  if (stopping) return {};
  sender_has_work = false;
  std::vector<Errands> all;
  all.reserve(cameras.size());
  for (auto& camera : cameras) {
    auto& errands = all.emplace_back();
    errands.link = link_of(camera.device.faults().in_force(now));
    while (const auto frame = camera.device.take_due(now)) errands.frames.push_back(*frame);
    while (const auto request = camera.device.take_resend()) errands.resends.push_back(*request);
    while (const auto packet = camera.device.take_test_packet()) errands.test_packets.push_back(*packet);
  }
  return all;
}

void GigeStudio::Impl::run(std::size_t camera, const Errands& errands) {
  for (const auto& packet : errands.test_packets)
    if (errands.link == CameraStream::Link::up) streams[camera].send_test_packet(packet.destination, packet.bytes);
  for (const auto& request : errands.resends) streams[camera].resend(request, errands.link);
  for (const auto& frame : errands.frames) send_frame(camera, frame);
}

void GigeStudio::Impl::send_frame(std::size_t camera, const DueFrame& frame) {
  if (frame.destination.port == 0) return;
  streams[camera].make_room();
  std::span<const std::uint8_t> pixels;
  std::vector<std::uint8_t> re_exposed;
  try {
    pixels = picture_at(camera, frame.exposure_start);
    if (re_expose && frame.image_settings && pixels.size() == cameras[camera].picture_bytes)
      pixels = re_exposed = re_expose(camera, frame.exposure_start, *frame.image_settings, pixels);
  } catch (const std::exception& error) {
    if (missing_pictures[camera] == 0) spdlog::error("{}: no picture to send: {}", cameras[camera].name, error.what());
  }
  if (pixels.size() != cameras[camera].picture_bytes) {
    ++missing_pictures[camera];
    return;
  }
  streams[camera].add(gvsp_frame(frame, pixels, std::move(re_exposed), cameras[camera].sensor), frame.destination,
                      frame.packet_delay, frame.due + frame.transmission_delay, frame.faults);
  if (on_exposure)
    on_exposure({.camera = camera, .block = frame.block, .start = frame.exposure_start, .duration = frame.exposure});
}

// Burst by burst in turn, as the cameras would share a switch.
void GigeStudio::Impl::send_bursts(const std::vector<Errands>& errands) {
  const Timestamp now = RigClock::now();
  for (bool sent = true; sent;) {
    sent = false;
    for (std::size_t i = 0; i < streams.size(); ++i) sent |= streams[i].send_due(now, errands[i].link);
  }
}

void GigeStudio::Impl::publish_and_wait() {
  std::optional<Timestamp> next;
  const auto consider = [&](std::optional<Timestamp> when) {
    if (when && (!next || *when < *next)) next = when;
  };
  for (const auto& stream : streams) consider(stream.next_burst());
  std::unique_lock lock(mutex);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].sent = streams[i].counts();
    cameras[i].missing_pictures = missing_pictures[i];
  }
  consider(next_due());
  const auto longest = std::chrono::nanoseconds{kLongestWait};
  const auto pause = next ? std::clamp(*next - RigClock::now(), 0ns, longest) : longest;
  wake.wait_for(lock, pause, [this] { return sender_has_work || stopping; });
}

// --- studio -----------------------------------------------------------------------------------------------------

GigeStudio::GigeStudio(const std::vector<GigeCameraOptions>& cameras, PictureAt picture_at,
                       const GigeStudioOptions& options)
    : impl_(std::make_unique<Impl>(cameras, std::move(picture_at), options)) {}

GigeStudio::~GigeStudio() {
  stop();
}

void GigeStudio::start() {
  impl_->control = std::jthread([impl = impl_.get()] { impl->control_loop(); });
  impl_->sender = std::jthread([impl = impl_.get()] { impl->sender_loop(); });
}

void GigeStudio::stop() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->stopping = true;
    impl_->control_stopping = true;
  }
  impl_->wake.notify_one();
  if (impl_->sender.joinable()) impl_->sender.join();
  if (impl_->control.joinable()) impl_->control.join();
}

std::size_t GigeStudio::size() const {
  return impl_->cameras.size();
}

std::vector<GigeStats> GigeStudio::stats() const {
  const Timestamp now = RigClock::now();
  const std::scoped_lock lock(impl_->mutex);
  std::vector<GigeStats> all;
  for (const auto& camera : impl_->cameras) {
    const auto& heard = camera.device.counts();
    FaultCounts fired = heard.faults;
    fired += camera.sent.faults;
    all.push_back({.frames_sent = camera.sent.frames_sent,
                   .missing_pictures = camera.missing_pictures,
                   .packets_sent = camera.sent.packets_sent,
                   .packets_lost = camera.sent.packets_lost,
                   .packets_resent = camera.sent.packets_resent,
                   .packets_unavailable = camera.sent.packets_unavailable,
                   .send_errors = camera.sent.send_errors,
                   .resend_requests = heard.resend_requests,
                   .triggers = heard.triggers,
                   .ignored_triggers = heard.ignored_triggers,
                   .late_actions = heard.late_actions,
                   .denied = heard.denied,
                   .lost_controllers = heard.lost_controllers,
                   .pending_acks = heard.pending_acks,
                   .has_controller = camera.device.has_controller(),
                   .is_acquiring = camera.device.is_acquiring(),
                   .faults = fired,
                   .in_force = camera.device.faults().kinds_in_force(now)});
  }
  return all;
}

GigeDevice& GigeStudio::Impl::device(std::size_t camera) {
  if (camera >= cameras.size())
    throw InvalidInput(fmt::format("there is no simulated camera {} of {}", camera, cameras.size()));
  return cameras[camera].device;
}

void GigeStudio::set_faults(std::size_t camera, const GigeFaults& faults) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->device(camera).faults().set_standing(faults);
}

void GigeStudio::set_faults(const GigeFaults& faults) {
  for (std::size_t i = 0; i < size(); ++i) set_faults(i, faults);
}

void GigeStudio::add_fault(std::size_t camera, const Fault& fault, Timestamp from) {
  const std::scoped_lock lock(impl_->mutex);
  if (!impl_->device(camera).faults().add(fault, from))
    throw InvalidInput(fmt::format("{}: {} faults are scheduled already; clear some first", impl_->cameras[camera].name,
                                   FaultSchedule::kMaxFaults));
}

void GigeStudio::clear_faults(std::size_t camera) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->device(camera).faults().clear();
}

void GigeStudio::seed_faults(std::uint64_t seed) {
  const std::scoped_lock lock(impl_->mutex);
  for (auto& camera : impl_->cameras) camera.device.faults().set_seed(seed);
}

std::uint16_t GigeStudio::trigger_box_port() const {
  return impl_->trigger_box ? impl_->trigger_box->port() : 0;
}

void GigeStudio::line0_edge(Timestamp at) {
  const std::scoped_lock lock(impl_->mutex);
  for (auto& camera : impl_->cameras) camera.device.line0_edge(at);
  impl_->sender_has_work = true;
  impl_->wake.notify_one();
}

}  // namespace rotunda::simulator
