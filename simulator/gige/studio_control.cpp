// The thread that answers GVCP, and the trigger line.
#include <sys/prctl.h>

#include <algorithm>

#include "capture/base/timely_thread.h"
#include "simulator/gige/gige_studio_impl.h"

namespace rotunda::simulator {

using capture::RigClock;
using capture::Timestamp;

void GigeStudio::Impl::control_loop() {
  prctl(PR_SET_NAME, "gige-control");
  capture::make_this_thread_timely();  // cameras do not wait for this machine
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

void GigeStudio::Impl::drain(UdpSocket& socket, std::span<StudioCamera> hearers) {
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

void GigeStudio::Impl::hand_to(StudioCamera& camera, std::span<const std::uint8_t> datagram,
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
  const bool has_errand = std::any_of(cameras.begin(), cameras.end(),
                                      [](const StudioCamera& camera) { return camera.device.has_errand(); });
  if (!has_errand && next_due() == due_before) return;
  sender_has_work = true;
  wake.notify_one();
}

}  // namespace rotunda::simulator
