#pragma once
// The inside of GigeStudio, private to its three files: the studio (gige_studio.cpp), the thread that answers GVCP
// (studio_control.cpp), the thread that streams and resends GVSP packets (studio_sender.cpp).
#include <sys/epoll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "simulator/gige/camera_stream.h"
#include "simulator/gige/gige_device.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/gige/region.h"
#include "simulator/gige/studio_sockets.h"
#include "simulator/gige/trigger_box.h"

namespace rotunda::simulator {

constexpr std::chrono::nanoseconds kLongestWait =
    std::chrono::milliseconds(100);  // both threads look at the clock so often

struct EpollHandle {
  int fd = epoll_create1(EPOLL_CLOEXEC);
  EpollHandle() = default;
  EpollHandle(const EpollHandle&) = delete;
  EpollHandle& operator=(const EpollHandle&) = delete;
  ~EpollHandle() { close(fd); }
};

struct StudioCamera {
  StudioCamera(const GigeCameraOptions& options, bool is_clock_master);

  std::string name;
  Region sensor;
  std::size_t picture_bytes;
  UdpSocket control, stream;
  // Shared by both threads, under the studio's mutex:
  GigeDevice device;
  StreamCounts sent;
  std::uint64_t missing_pictures = 0;
};

// What the sender takes along when it leaves the mutex.
struct Errands {
  std::vector<DueFrame> frames;
  std::vector<ResendCommand> resends;
  std::vector<TestPacket> test_packets;
  CameraStream::Link link = CameraStream::Link::up;
};

struct GigeStudio::Impl {
  Impl(const std::vector<GigeCameraOptions>& options, PictureAt picture, const GigeStudioOptions& studio);
  void watch(const UdpSocket& socket, std::size_t number) const;

  void control_loop();
  void drain(UdpSocket& socket, std::span<StudioCamera> hearers);
  void drain_trigger_box();
  void hand_to(StudioCamera& camera, std::span<const std::uint8_t> datagram, const UdpSocket::Received& received);
  std::chrono::nanoseconds send_late_acknowledgements(capture::Timestamp now);
  std::optional<capture::Timestamp> next_due() const;
  void wake_sender_if_needed(std::optional<capture::Timestamp> due_before);

  void sender_loop();
  std::vector<Errands> collect(capture::Timestamp now);
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
  std::vector<StudioCamera> cameras;
  bool sender_has_work = false, stopping = false;  // under the mutex
  // The sender's own:
  std::vector<CameraStream> streams;
  std::vector<std::uint64_t> missing_pictures;
  std::array<std::uint8_t, 2048> buffer{};  // the control thread's own
  std::atomic<bool> control_stopping = false;
  std::jthread control, sender;
};

}  // namespace rotunda::simulator
