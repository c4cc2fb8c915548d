// The thread that streams and resends GVSP packets.
#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <algorithm>

#include "capture/base/timely_thread.h"
#include "simulator/gige/gige_studio_impl.h"

namespace rotunda::simulator {

using capture::RigClock;
using capture::Timestamp;
using namespace std::chrono_literals;

namespace {

CameraStream::Link link_of(const GigeFaults& faults) {
  if (faults.silent) return CameraStream::Link::silent;
  return faults.rebooting ? CameraStream::Link::rebooting : CameraStream::Link::up;
}

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

}  // namespace

void GigeStudio::Impl::sender_loop() {
  prctl(PR_SET_NAME, "gige-sender");
  prctl(PR_SET_TIMERSLACK, 1);
  capture::make_this_thread_timely();  // cameras do not wait for this machine
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

}  // namespace rotunda::simulator
