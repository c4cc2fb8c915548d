#include "simulator/gige/gige_studio.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "config/errors.h"
#include "simulator/gige/gige_studio_impl.h"

namespace rotunda::simulator {

using capture::RigClock;
using capture::Timestamp;
using namespace std::chrono_literals;

namespace {

constexpr auto kUptime = 1h;  // of the cameras when the studio opens: their clocks have settled

void check(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

StudioCamera::StudioCamera(const GigeCameraOptions& options, bool is_clock_master)
    : name(options.name),
      sensor{static_cast<std::uint32_t>(options.width), static_cast<std::uint32_t>(options.height)},
      picture_bytes(simulator::picture_bytes(pixel_code(options.format), sensor.width, sensor.height)),
      control(control_socket(options)),
      stream(stream_socket(options)),
      device(options, is_clock_master ? PtpStatus::master : PtpStatus::slave, stream.port(),
             RigClock::now() - kUptime) {}

GigeStudio::Impl::Impl(const std::vector<GigeCameraOptions>& options, PictureAt picture,
                       const GigeStudioOptions& studio)
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

void GigeStudio::Impl::watch(const UdpSocket& socket, std::size_t number) const {
  epoll_event event{.events = EPOLLIN, .data = {.u64 = number}};
  check(epoll_ctl(poll.fd, EPOLL_CTL_ADD, socket.fd(), &event), "epoll_ctl");
}

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
