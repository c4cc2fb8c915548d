// Ten simulated GigE Vision cameras, 720 x 576, received by unmodified Aravis: 25 Hz by scheduled actions, beside the
// same bytes at the same times by bare sendmmsg(), recv() and a write() a frame; and 1.15 GB/s unpaced, beside what
// bare sockets carry at most. Prints frames complete and the CPU time of each side's threads.
//   gige_bench [seconds] [packet size] [realtime]
#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <system_error>
#include <thread>

#include "simulator/gige/gige_studio.h"
#include "tests/support/aravis_client.h"
#include "tests/support/private_network.h"

namespace rotunda {
namespace {

using capture::RigClock;
using capture::Timestamp;
using namespace std::chrono_literals;

constexpr std::size_t kCameras = 10, kWidth = 720, kHeight = 576, kPictureBytes = kWidth * kHeight;
constexpr auto kPeriod = 40ms;

constexpr double kAggregateBytes = 1.15e9;  // a second, asked of ten cameras together
constexpr int kRealTimePriority = 20;

struct Run {
  int triggers = 250;
  int packet_size = 8900;
};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// CPU seconds of this process' threads whose names start so.
double cpu_seconds_of(const std::string& name) {
  double seconds = 0.0;
  DIR* tasks = opendir("/proc/self/task");
  while (const dirent* task = readdir(tasks)) {
    const std::string folder = std::string("/proc/self/task/") + task->d_name;
    std::string comm;
    std::uint64_t nanoseconds = 0;
    std::getline(std::ifstream(folder + "/comm"), comm);
    std::ifstream(folder + "/schedstat") >> nanoseconds;
    if (comm.rfind(name, 0) == 0) seconds += 1e-9 * static_cast<double>(nanoseconds);
  }
  closedir(tasks);
  return seconds;
}

double cpu_seconds_of_this_thread() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

std::vector<std::vector<std::uint8_t>> pictures() {
  std::vector<std::vector<std::uint8_t>> all(kCameras, std::vector<std::uint8_t>(kPictureBytes));
  for (std::size_t i = 0; i < kCameras; ++i) std::iota(all[i].begin(), all[i].end(), static_cast<std::uint8_t>(i));
  return all;
}

std::vector<simulator::GigeCameraOptions> cameras() {
  std::vector<simulator::GigeCameraOptions> all;
  for (std::size_t i = 0; i < kCameras; ++i)
    all.push_back({.name = fmt::format("cam{:02}", i),
                   .serial = fmt::format("RS{:04}", i),
                   .address = fmt::format("127.0.0.{}", i + 1),
                   .mac = {2, 0, 0, 0, 0, static_cast<std::uint8_t>(i)}});
  return all;
}

struct Result {
  std::size_t complete = 0, wrong_time = 0, other = 0;
};

// Counts one camera's frames until no more come.
Result count_frames(tests::AravisClient& client, Timestamp first, const Run& run) {
  Result result;
  for (int k = 0; k < run.triggers; ++k) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(client.stream(), 3'000'000);
    if (buffer == nullptr) break;
    const auto since = static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer)) - first.time_since_epoch().count();
    const bool complete = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS;
    ++(complete ? result.complete : result.other);
    result.wrong_time += complete && since % std::chrono::nanoseconds{kPeriod}.count() != 0;
    arv_stream_push_buffer(client.stream(), buffer);
  }
  return result;
}

void send_actions(Timestamp first, int triggers) {
  tests::ActionSender actions;
  for (int k = 0; k < triggers; ++k) {
    const Timestamp at = first + k * kPeriod;
    std::this_thread::sleep_for(at - 2 * kPeriod - RigClock::now());
    actions.send(at, 0);
  }
}

void run_studio(const Run& run) {
  const auto shown = pictures();
  simulator::GigeStudio studio(cameras(), [&](std::size_t camera, Timestamp) { return std::span{shown[camera]}; });
  studio.start();
  std::vector<std::unique_ptr<tests::AravisClient>> clients;
  for (const auto& camera : cameras()) {
    clients.push_back(std::make_unique<tests::AravisClient>(camera.address, run.packet_size));
    clients.back()->trigger_by("Action1");
    clients.back()->start();
  }
  const double sender = cpu_seconds_of("gige-sender"), control = cpu_seconds_of("gige-control");
  const Timestamp first = RigClock::now() + 500ms;
  std::vector<Result> results(kCameras);
  {
    std::vector<std::jthread> counters;
    for (std::size_t i = 0; i < kCameras; ++i)
      counters.emplace_back([&, i] { results[i] = count_frames(*clients[i], first, run); });
    send_actions(first, run.triggers);
  }
  Result all;
  for (const auto& each : results)
    all = {all.complete + each.complete, all.wrong_time + each.wrong_time, all.other + each.other};
  std::uint64_t resent = 0, late = 0, sent = 0, skipped = 0;
  for (const auto& stats : studio.stats()) {
    resent += stats.packets_resent;
    late += stats.late_actions;
    sent += stats.frames_sent;
    skipped += stats.ignored_triggers + stats.missing_pictures;
  }
  const double seconds = run.triggers * std::chrono::duration<double>(kPeriod).count();
  fmt::print(
      "studio     {:5} of {} frames complete, {} off their time, {} failed, {} packets resent, {} late actions\n",
      all.complete, kCameras * static_cast<std::size_t>(run.triggers), all.wrong_time, all.other, resent, late);
  fmt::print("           {} slots sent, {} skipped\n", sent, skipped);
  fmt::print("           CPU of one core: sender {:.1f} %, control {:.1f} %, client (Aravis) {:.1f} %\n",
             100.0 * (cpu_seconds_of("gige-sender") - sender) / seconds,
             100.0 * (cpu_seconds_of("gige-control") - control) / seconds,
             100.0 * cpu_seconds_of("arv_gv_stream") / seconds);
}

// Free run, each frame in one burst, as fast as ten cameras must be for the aggregate.
void run_aggregate(const Run& run) {
  constexpr double kRate = kAggregateBytes / (kCameras * kPictureBytes);
  constexpr auto kDuration = 5s;
  const auto shown = pictures();
  simulator::GigeStudio studio(cameras(), [&](std::size_t camera, Timestamp) { return std::span{shown[camera]}; },
                               {.link_bits_per_second = 0.0});
  studio.start();
  std::vector<std::unique_ptr<tests::AravisClient>> clients;
  for (const auto& camera : cameras()) {
    clients.push_back(std::make_unique<tests::AravisClient>(camera.address, run.packet_size));
    clients.back()->set("TriggerMode", "Off");
    clients.back()->set_float("ExposureTime", 100.0);
    clients.back()->set_float("AcquisitionFrameRate", kRate);
    clients.back()->start({.buffers = 40});
  }
  std::atomic<std::uint64_t> complete = 0, failed = 0;
  const double before = cpu_seconds_of("gige-");
  const auto start = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> counters;
    for (auto& client : clients)
      counters.emplace_back([&, stream = client->stream()] {
        while (std::chrono::steady_clock::now() < start + kDuration) {
          ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 100'000);
          if (buffer == nullptr) continue;
          ++(arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS ? complete : failed);
          arv_stream_push_buffer(stream, buffer);
        }
      });
  }
  const double seconds = 1e-3 * milliseconds_since(start);
  fmt::print("aggregate  {:.2f} GB/s: {} frames complete, {} failed; device {:.0f} % of a core\n",
             1e-9 * static_cast<double>(complete * kPictureBytes) / seconds, complete.load(), failed.load(),
             100.0 * (cpu_seconds_of("gige-") - before) / seconds);
}

struct Bare {
  std::atomic<bool> stop = false;
  std::atomic<std::uint64_t> packets = 0;
  std::atomic<double> cpu_seconds = 0.0;  // of the readers
};

// Takes in what comes until told to stop and writes it to a file, a frame at a time: the least that capture can do.
void store(int socket, int file, Bare& bare) {
  std::vector<std::uint8_t> memory(kPictureBytes + 65536);
  std::size_t filled = 0;
  const timeval pause{.tv_sec = 0, .tv_usec = 100'000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &pause, sizeof pause);
  while (!bare.stop) {
    const auto got = recv(socket, memory.data() + filled, 65536, 0);
    if (got <= 0) continue;
    ++bare.packets;
    filled += static_cast<std::size_t>(got);
    if (filled < kPictureBytes) continue;
    if (write(file, memory.data(), filled) < 0) throw std::system_error(errno, std::generic_category(), "write");
    filled = 0;
  }
  bare.cpu_seconds += cpu_seconds_of_this_thread();
}

// A file without a name, gone when closed.
int nameless_file() {
  const auto folder = std::filesystem::temp_directory_path();
  const int file = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) throw std::system_error(errno, std::generic_category(), folder.string());
  return file;
}

// One frame as bare datagrams, one system call.
void send_bare(int socket, sockaddr_in to, std::span<const std::uint8_t> pixels, std::size_t datagram) {
  const std::size_t count = (pixels.size() + datagram - 1) / datagram;
  std::vector<iovec> pieces(count);
  std::vector<mmsghdr> messages(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto part = pixels.subspan(i * datagram, std::min(datagram, pixels.size() - i * datagram));
    pieces[i] = {const_cast<std::uint8_t*>(part.data()), part.size()};
    messages[i].msg_hdr.msg_name = &to;
    messages[i].msg_hdr.msg_namelen = sizeof to;
    messages[i].msg_hdr.msg_iov = &pieces[i];
    messages[i].msg_hdr.msg_iovlen = 1;
  }
  sendmmsg(socket, messages.data(), static_cast<unsigned>(count), 0);
}

void run_bare(const Run& run) {
  const auto shown = pictures();
  const int large = 4 << 20;
  Bare bare;
  std::vector<std::unique_ptr<simulator::UdpSocket>> sinks;
  std::vector<int> files;
  std::vector<std::jthread> readers;
  for (std::size_t i = 0; i < kCameras; ++i) {
    sinks.push_back(std::make_unique<simulator::UdpSocket>(simulator::Endpoint{INADDR_LOOPBACK, 0}));
    setsockopt(sinks[i]->fd(), SOL_SOCKET, SO_RCVBUF, &large, sizeof large);
    files.push_back(nameless_file());
    readers.emplace_back([&, i] { store(sinks[i]->fd(), files[i], bare); });
  }
  simulator::UdpSocket source({INADDR_LOOPBACK, 0});
  const double before = cpu_seconds_of_this_thread();
  const auto first = std::chrono::steady_clock::now();
  const auto datagram = static_cast<std::size_t>(run.packet_size) - 28;
  for (int k = 0; k < run.triggers; ++k) {
    std::this_thread::sleep_until(first + k * kPeriod);
    for (std::size_t i = 0; i < kCameras; ++i) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(sinks[i]->port());
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      send_bare(source.fd(), to, shown[i], datagram);
    }
  }
  const double cpu = cpu_seconds_of_this_thread() - before;
  std::this_thread::sleep_for(500ms);
  bare.stop = true;
  readers.clear();
  for (const int file : files) close(file);
  const auto expected = (kPictureBytes + datagram - 1) / datagram * kCameras * static_cast<std::size_t>(run.triggers);
  const double seconds = run.triggers * std::chrono::duration<double>(kPeriod).count();
  fmt::print(
      "bare UDP   {:5} of {} packets arrived\n           CPU of one core: sender {:.1f} %, receive and write {:.1f} "
      "%\n",
      bare.packets.load(), expected, 100.0 * cpu / seconds, 100.0 * bare.cpu_seconds / seconds);
}

// As much as sendmmsg() and recvmmsg() move between ten pairs of sockets, a frame in turn for each: the bound of any
// device and client on this machine. What overruns a socket's buffer is lost.
void run_bare_aggregate(const Run& run) {
  constexpr auto kDuration = 5s;
  constexpr unsigned kBatch = 64;
  const auto shown = pictures();
  const int large = 4 << 20;
  std::atomic<bool> stop = false;
  std::atomic<std::uint64_t> arrived = 0;
  std::vector<std::unique_ptr<simulator::UdpSocket>> sinks;
  std::vector<std::jthread> readers;
  for (std::size_t i = 0; i < kCameras; ++i) {
    sinks.push_back(std::make_unique<simulator::UdpSocket>(simulator::Endpoint{INADDR_LOOPBACK, 0}));
    setsockopt(sinks[i]->fd(), SOL_SOCKET, SO_RCVBUF, &large, sizeof large);
    readers.emplace_back([&, fd = sinks[i]->fd()] {
      std::vector<std::uint8_t> memory(kBatch * 65536);
      std::vector<iovec> pieces(kBatch);
      std::vector<mmsghdr> messages(kBatch);
      for (unsigned k = 0; k < kBatch; ++k) {
        pieces[k] = {memory.data() + k * 65536, 65536};
        messages[k].msg_hdr.msg_iov = &pieces[k];
        messages[k].msg_hdr.msg_iovlen = 1;
      }
      const timeval pause{.tv_sec = 0, .tv_usec = 100'000};
      setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &pause, sizeof pause);
      while (!stop) {
        const int got = recvmmsg(fd, messages.data(), kBatch, MSG_WAITFORONE, nullptr);
        for (int k = 0; k < got; ++k) arrived += messages[static_cast<std::size_t>(k)].msg_len;
      }
    });
  }
  simulator::UdpSocket source({INADDR_LOOPBACK, 0});
  std::uint64_t sent = 0;
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() < start + kDuration)
    for (std::size_t i = 0; i < kCameras; ++i) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(sinks[i]->port());
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      send_bare(source.fd(), to, shown[i], static_cast<std::size_t>(run.packet_size) - 28);
      sent += kPictureBytes;
    }
  const double seconds = 1e-3 * milliseconds_since(start);
  stop = true;
  readers.clear();
  fmt::print("           bare sendmmsg and recvmmsg: {:.2f} GB/s sent, {:.2f} arrived\n",
             1e-9 * static_cast<double>(sent) / seconds, 1e-9 * static_cast<double>(arrived.load()) / seconds);
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  rotunda::Run run;
  if (argc > 1) run.triggers = 25 * std::atoi(argv[1]);
  if (argc > 2) run.packet_size = std::atoi(argv[2]);
  const sched_param priority{.sched_priority = rotunda::kRealTimePriority};
  const bool realtime = argc > 3 && sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  if (argc > 3 && !realtime) fmt::print(stderr, "gige_bench: no real-time priority here\n");
  const auto refusal = rotunda::tests::enter_private_network();
  if (!refusal.empty()) fmt::print(stderr, "gige_bench: {}; using the machine's own loopback\n", refusal);
  fmt::print("{} cameras, {} x {}, 25 Hz, {} triggers, {} byte packets{}\n", rotunda::kCameras, rotunda::kWidth,
             rotunda::kHeight, run.triggers, run.packet_size, realtime ? ", real-time priority" : "");
  rotunda::run_studio(run);
  rotunda::run_bare(run);
  rotunda::run_aggregate(run);
  rotunda::run_bare_aggregate(run);
}
