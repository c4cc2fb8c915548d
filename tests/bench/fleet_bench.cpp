// The daemon's camera fleet against ten simulated cameras in one process, at 25 Hz: how long ten cameras take from
// nothing to streaming; how long from the last packet of a trigger to its frame set in the queue, on a clean link and
// on one that loses 1 % of the packets in bursts of eight; how long ten dead cameras take to be told and torn down.
// Beside it what this machine does with a bare datagram and a bare timer. Priorities as the programs have them: run it
// by chrt.
//   fleet_bench RIG.yaml [seconds]
#include <fmt/format.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <numeric>
#include <optional>
#include <system_error>
#include <thread>

#include "capture/base/unique_fd.h"
#include "config/rig_config.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/frame_set_stream.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/gige/udp_socket.h"
#include "tests/support/private_network.h"

namespace rotunda {
namespace {

using capture::RigClock;
using capture::Timestamp;
using std::chrono::steady_clock;
using namespace std::chrono_literals;

double milliseconds(std::chrono::nanoseconds time) {
  return 1e-6 * static_cast<double>(time.count());
}

// Told of in milliseconds.
struct Latencies {
  std::vector<double> all;
  double at(double share) {
    if (all.empty()) return 0.0;
    std::sort(all.begin(), all.end());
    return all[std::min(all.size() - 1, static_cast<std::size_t>(share * static_cast<double>(all.size())))];
  }
};

void print_row(const std::string& name, Latencies latencies) {
  fmt::print("{:<34} p50 {:.3f} ms, p99 {:.3f} ms, max {:.3f} ms\n", name, latencies.at(0.5), latencies.at(0.99),
             latencies.at(1.0));
}

// When the last packets of frames (GVSP trailers) went over the loopback, by the kernel's own stamps.
class Trailers {
 public:
  Trailers() : fd_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP))) {
    constexpr std::uint32_t kProtocol = 9, kGvspFormat = 20 + 8 + 4;  // from the IPv4 header on
    std::array<sock_filter, 6> program{sock_filter{BPF_LD | BPF_B | BPF_ABS, 0, 0, kProtocol},
                                       sock_filter{BPF_JMP | BPF_JEQ | BPF_K, 0, 3, IPPROTO_UDP},
                                       sock_filter{BPF_LD | BPF_B | BPF_ABS, 0, 0, kGvspFormat},
                                       sock_filter{BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 2},
                                       sock_filter{BPF_RET | BPF_K, 0, 0, 64},
                                       sock_filter{BPF_RET | BPF_K, 0, 0, 0}};
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    const int on = 1;
    const timeval pause{.tv_sec = 0, .tv_usec = 100'000};
    if (!fd_ || setsockopt(fd_.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0 ||
        setsockopt(fd_.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(fd_.get(), SOL_SOCKET, SO_RCVTIMEO, &pause, sizeof pause) != 0)
      throw std::system_error(errno, std::generic_category(), "a packet socket, to see when packets leave");
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) listen();
    });
  }

  // The last one between two moments.
  std::optional<Timestamp> last_between(Timestamp from, Timestamp to) const {
    const std::lock_guard lock(mutex_);
    const auto past = std::upper_bound(stamps_.begin(), stamps_.end(), to);
    return past == stamps_.begin() || *(past - 1) < from ? std::nullopt : std::optional(*(past - 1));
  }

 private:
  void listen() {
    std::array<char, 64> packet{};
    alignas(cmsghdr) std::array<char, 128> control{};
    iovec piece{packet.data(), packet.size()};
    msghdr message{};
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (recvmsg(fd_.get(), &message, 0) <= 0) return;
    const cmsghdr* told = CMSG_FIRSTHDR(&message);
    if (told == nullptr || told->cmsg_type != SCM_TIMESTAMPNS) return;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(told), sizeof stamp);
    const std::lock_guard lock(mutex_);
    stamps_.push_back(
        Timestamp(std::chrono::seconds{stamp.tv_sec} + std::chrono::nanoseconds{stamp.tv_nsec} + rig_ahead()));
  }
  // Of the clock that the kernel stamps by: asked with every stamp, that clock may be moved meanwhile.
  static std::chrono::nanoseconds rig_ahead() {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    return RigClock::now().time_since_epoch() - std::chrono::seconds{now.tv_sec} -
           std::chrono::nanoseconds{now.tv_nsec};
  }

  capture::UniqueFd fd_;
  mutable std::mutex mutex_;
  std::vector<Timestamp> stamps_;
  std::jthread thread_;
};

// Ten cameras that show noise.
class Studio {
 public:
  explicit Studio(const config::RigConfig& rig)
      : picture_(static_cast<std::size_t>(rig.cameras[0].width) * static_cast<std::size_t>(rig.cameras[0].height)),
        studio_(cameras_of(rig), [this](std::size_t, Timestamp) { return std::span<const std::uint8_t>(picture_); }) {
    std::iota(picture_.begin(), picture_.end(), std::uint8_t{0});
    studio_.start();
  }
  simulator::GigeStudio& operator*() { return studio_; }
  std::uint64_t lost_packets() const {
    std::uint64_t lost = 0;
    for (const auto& camera : studio_.stats()) lost += camera.packets_lost;
    return lost;
  }

 private:
  static std::vector<simulator::GigeCameraOptions> cameras_of(const config::RigConfig& rig) {
    std::vector<simulator::GigeCameraOptions> all;
    for (std::size_t i = 0; i < rig.cameras.size(); ++i)
      all.push_back({.name = rig.cameras[i].name,
                     .serial = fmt::format("RS{:04}", i),
                     .address = rig.cameras[i].device,
                     .mac = {2, 0, 0, 0, 0, static_cast<std::uint8_t>(i)},
                     .width = rig.cameras[i].width,
                     .height = rig.cameras[i].height});
    return all;
  }

  std::vector<std::uint8_t> picture_;
  simulator::GigeStudio studio_;
};

std::vector<capture::CameraId> names_of(const config::RigConfig& rig) {
  std::vector<capture::CameraId> names;
  for (const auto& camera : rig.cameras) names.push_back(camera.name);
  return names;
}

// From no worker to every camera streaming.
double milliseconds_to_open(const config::RigConfig& rig) {
  const auto began = steady_clock::now();
  const rig::CameraFleet fleet(rig);
  while (fleet.streaming() < rig.cameras.size()) std::this_thread::sleep_for(100us);
  return milliseconds(steady_clock::now() - began);
}

void run_opening(const config::RigConfig& rig) {
  std::vector<double> rounds;
  for (int i = 0; i < 9; ++i) rounds.push_back(milliseconds_to_open(rig));
  std::sort(rounds.begin(), rounds.end());
  fmt::print("{:<34} median {:.1f} ms, longest {:.1f} ms\n", "opening ten cameras", rounds[rounds.size() / 2],
             rounds.back());
}

// Exposure and link take 8.5 ms; what comes much later was sent again.
constexpr auto kFrameTime = 10ms;

struct Stamped {
  Timestamp trigger, queued;
  bool complete = false;
};

// From the last packet that was to come, to the set in the queue; where some are lost, without those sent again.
void run_latency(const config::RigConfig& rig, Studio& studio, const std::string& name, std::uint64_t sets) {
  rig::CameraFleet fleet(rig);
  fleet.wait_until_tried({});
  const Trailers trailers;
  std::vector<Stamped> all;
  const auto lost_before = studio.lost_packets();
  rig::FrameSetStream stream({.trigger = rig.trigger, .wanted = sets, .cameras = names_of(rig), .deadline = 1s}, fleet);
  stream.start([&](capture::FrameSet&& set) { all.push_back({set.time, RigClock::now(), set.complete()}); });
  while (stream.advance()) std::this_thread::sleep_for(20ms);
  Latencies latencies;
  std::size_t complete = 0;
  const auto lost = studio.lost_packets() - lost_before;
  for (const auto& set : all) {
    complete += set.complete;
    const auto over = lost == 0 ? set.queued : std::min(set.queued, set.trigger + kFrameTime);
    const auto last = trailers.last_between(set.trigger, over);
    if (last) latencies.all.push_back(milliseconds(set.queued - *last));
  }
  fmt::print("{:<34} {} of {} complete, {} packets lost\n", name + ": frame sets", complete, sets, lost);
  if (latencies.all.size() < all.size())
    fmt::print("{:<34} {} of them seen\n", name + ": last packets", latencies.all.size());
  print_row(name + ": last packet to queue", std::move(latencies));
}

// Until all are told as gone, and until nothing of them is left.
void run_death(const config::RigConfig& rig, Studio& studio) {
  auto fleet = std::make_unique<rig::CameraFleet>(rig);
  fleet->wait_until_tried({});
  auto stream = std::make_unique<rig::FrameSetStream>(
      rig::FrameSetStreamOptions{.trigger = rig.trigger, .wanted = {}, .cameras = names_of(rig), .deadline = 1s},
      *fleet);
  stream->start([](capture::FrameSet&&) {});
  for (int i = 0; i < 25; ++i, std::this_thread::sleep_for(20ms)) stream->advance();
  const auto died = steady_clock::now();
  (*studio).set_faults({.silent = true});
  std::optional<double> first;
  while (!stream->all_gone()) {
    stream->advance();
    if (!first && !stream->take_incidents().empty()) first = milliseconds(steady_clock::now() - died);
    std::this_thread::sleep_for(5ms);
  }
  const double gone = milliseconds(steady_clock::now() - died);
  stream->stop();
  stream.reset();
  fleet.reset();
  fmt::print("{:<34} first told {:.0f} ms, all gone {:.0f} ms, torn down {:.0f} ms\n", "ten dead cameras",
             first.value_or(0.0), gone, milliseconds(steady_clock::now() - died));
}

// A datagram to a thread that waits for it, 25 times a second.
void run_bare(int datagrams) {
  simulator::UdpSocket from({INADDR_LOOPBACK, 0}), to({INADDR_LOOPBACK, 0});
  Latencies datagram, timer;
  Timestamp sent;
  std::mutex mutex;
  std::jthread reader([&] {
    std::vector<std::uint8_t> buffer(65536);
    pollfd ready{.fd = to.fd(), .events = POLLIN, .revents = 0};
    for (int i = 0; i < datagrams && poll(&ready, 1, 1000) > 0; ++i) {
      while (to.receive(buffer))
        ;
      const auto now = RigClock::now();
      const std::lock_guard lock(mutex);
      datagram.all.push_back(milliseconds(now - sent));
    }
  });
  auto next = steady_clock::now();
  for (int i = 0; i < datagrams; ++i) {
    std::this_thread::sleep_until(next += 4ms);
    timer.all.push_back(milliseconds(steady_clock::now() - next));
    {
      const std::lock_guard lock(mutex);
      sent = RigClock::now();
    }
    from.send(std::vector<std::uint8_t>(8900), {INADDR_LOOPBACK, to.port()});
  }
  reader.join();
  print_row("bare datagram to a waiting thread", std::move(datagram));
  print_row("bare timer", std::move(timer));
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "fleet_bench RIG.yaml [seconds]\n");
    return 2;
  }
  const int seconds = argc > 2 ? std::max(1, std::atoi(argv[2])) : 30;
  spdlog::set_level(spdlog::level::off);
  if (const auto refusal = rotunda::tests::enter_private_network(); !refusal.empty())
    fmt::print(stderr, "fleet_bench: {}; using the machine's own loopback\n", refusal);
  const auto rig = rotunda::config::load_rig(argv[1]);
  const auto sets = static_cast<std::uint64_t>(rig.trigger.rate_hz * seconds);
  rotunda::Studio studio(rig);
  rotunda::run_opening(rig);
  rotunda::run_latency(rig, studio, "clean", sets);
  (*studio).set_faults({.seed = 7, .packet_loss = {.rate = 0.01, .burst = 8}});
  rotunda::run_latency(rig, studio, "1 % lost, bursts of 8", sets);
  (*studio).set_faults({});
  rotunda::run_death(rig, studio);
  rotunda::run_bare(500);
}
