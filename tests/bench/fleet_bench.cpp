// The daemon's camera fleet against ten simulated cameras in one process, at 25 Hz: how long ten cameras take from
// nothing to streaming; how long from the last packet of a trigger to its frame set in the queue, on a clean link and
// on one that loses 1 % of the packets in bursts of eight; how long ten dead cameras take to be told and torn down.
// Beside it what this machine does with a bare datagram and a bare timer. Priorities as the programs have them: run it
// by chrt.
//   fleet_bench RIG.yaml [seconds]
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <numeric>
#include <thread>

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

// From a trigger to the moment its last packet is due: the exposure, then the frame at the speed of the camera's link,
// all cameras at once. A simulator that sends late makes the latency longer, never shorter.
std::chrono::nanoseconds time_to_last_packet(const config::RigConfig& rig) {
  constexpr double kLink = 1e9;             // bits a second, GigeStudioOptions' default
  constexpr double kHeaders = 36.0;         // bytes of IP, UDP and GVSP in each packet
  constexpr double kBurst = 64.0 * 1024.0;  // bytes that leave at once: the last ones do not wait for their turn
  const auto& camera = rig.cameras[0];
  const double pixels = static_cast<double>(camera.width) * camera.height;
  const double packets = std::ceil(pixels / (camera.packet_size - kHeaders)) + 2.0;
  const double bursts = std::ceil(packets / std::floor(kBurst / camera.packet_size)) - 1.0;
  const double bits = 8.0 * bursts * std::floor(kBurst / camera.packet_size) * camera.packet_size;
  return std::chrono::nanoseconds(std::llround(1e3 * camera.exposure_us.value_or(5000.0) + 1e9 * bits / kLink));
}

struct Stamped {
  Timestamp trigger, queued;
  bool complete = false;
};

void run_latency(const config::RigConfig& rig, Studio& studio, const std::string& name, std::uint64_t sets) {
  rig::CameraFleet fleet(rig);
  fleet.wait_until_tried({});
  std::vector<Stamped> all;
  const auto lost_before = studio.lost_packets();
  rig::FrameSetStream stream({.trigger = rig.trigger, .wanted = sets, .cameras = names_of(rig), .deadline = 1s}, fleet);
  stream.start([&](capture::FrameSet&& set) { all.push_back({set.time, RigClock::now(), set.complete()}); });
  while (stream.advance()) std::this_thread::sleep_for(20ms);
  const auto last_packet = time_to_last_packet(rig);
  Latencies latencies;
  std::size_t complete = 0;
  for (const auto& set : all) {
    complete += set.complete;
    latencies.all.push_back(milliseconds(set.queued - set.trigger - last_packet));
  }
  fmt::print("{:<34} {} of {} complete, {} packets lost\n", name + ": frame sets", complete, sets,
             studio.lost_packets() - lost_before);
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
