// How long unmodified Aravis takes to open ten simulated cameras, one after the other and all at once, and what of it
// is Aravis' own: the same with devices that know nothing but what an opening asks for, with a description of one node
// and with the simulated cameras' own. Medians.
//   open_bench [rounds] [realtime]
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <thread>

#include "simulator/gige/genicam_xml.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/gige/zip_archive.h"
#include "tests/support/aravis_client.h"
#include "tests/support/private_network.h"

namespace rotunda {
namespace {

using simulator::GvcpOpcode;
using simulator::GvcpStatus;
using simulator::load_be;
using simulator::store_be;

constexpr std::size_t kCameras = 10;
constexpr int kRealTimePriority = 20;
constexpr std::uint32_t kDescription = 0x1000;

std::string address_of(std::size_t camera) {
  return fmt::format("127.0.0.{}", camera + 1);
}

constexpr const char* kOneNode =
    "<?xml version=\"1.0\"?><RegisterDescription ModelName=\"Bare\" VendorName=\"Bare\" "
    "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\"><Category Name=\"Root\"/><Port Name=\"Device\"/>"
    "</RegisterDescription>";

// Ten devices with one memory between them: a description, and whoever asks controls them.
class BareDevices {
 public:
  explicit BareDevices(const std::string& description) {
    const auto zipped = simulator::zip_archive("bare.xml", description);
    const std::string url = fmt::format("Local:bare.zip;{:x};{:x}", kDescription, zipped.size());
    std::copy(url.begin(), url.end(), memory_.begin() + 0x200);
    std::copy(zipped.begin(), zipped.end(), memory_.begin() + kDescription);
    memory_[0x48] = memory_[0x68] = 'b';  // vendor, model
    for (std::size_t i = 0; i < kCameras; ++i) {
      sockets_.emplace_back(simulator::Endpoint{INADDR_LOOPBACK + static_cast<std::uint32_t>(i), simulator::kGvcpPort});
      ready_.push_back({.fd = sockets_.back().fd(), .events = POLLIN, .revents = 0});
    }
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) serve();
    });
  }

 private:
  void serve() {
    if (poll(ready_.data(), ready_.size(), 50) <= 0) return;
    std::array<std::uint8_t, 1024> buffer{};
    for (auto& socket : sockets_)
      while (const auto received = socket.receive(buffer))
        if (const auto command = simulator::parse_gvcp(std::span{buffer}.first(received->bytes)))
          socket.send(answer(*command), received->from);
  }

  std::vector<std::uint8_t> answer(const simulator::GvcpCommand& command) {
    const auto address = load_be<std::uint32_t>(command.payload, 0);
    const auto at = std::span{memory_}.subspan(std::min<std::size_t>(address, memory_.size() - 1024));
    std::vector<std::uint8_t> payload(4);
    if (command.opcode == GvcpOpcode::read_memory) {
      std::copy_n(command.payload.begin(), 4, payload.begin());
      payload.insert(payload.end(), at.begin(), at.begin() + load_be<std::uint16_t>(command.payload, 6));
    } else if (command.opcode == GvcpOpcode::read_register) {
      std::copy_n(at.begin(), 4, payload.begin());
    } else {
      std::copy_n(command.payload.begin() + 4, 4, at.begin());
      store_be<std::uint16_t>(payload, 2, 1);
    }
    return simulator::gvcp_acknowledge(command, GvcpStatus::success, payload);
  }

  std::vector<std::uint8_t> memory_ = std::vector<std::uint8_t>(0x10000);
  std::vector<simulator::UdpSocket> sockets_;
  std::vector<pollfd> ready_;
  std::jthread thread_;
};

double milliseconds_to_open(bool at_once) {
  std::vector<std::unique_ptr<tests::AravisClient>> clients(kCameras);
  const auto open = [&](std::size_t i) { clients[i] = std::make_unique<tests::AravisClient>(address_of(i)); };
  const auto start = std::chrono::steady_clock::now();
  if (at_once) {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kCameras; ++i) threads.emplace_back(open, i);
  } else {
    for (std::size_t i = 0; i < kCameras; ++i) open(i);
  }
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median_of(int rounds, bool at_once) {
  std::vector<double> all;
  for (int i = 0; i < rounds; ++i) all.push_back(milliseconds_to_open(at_once));
  std::nth_element(all.begin(), all.begin() + rounds / 2, all.end());
  return all[static_cast<std::size_t>(rounds / 2)];
}

void print_row(const char* name, int rounds) {
  { const tests::AravisClient warm(address_of(0)); }  // Aravis' own start
  const double one_by_one = median_of(rounds, false), at_once = median_of(rounds, true);
  fmt::print("{:<22} {} cameras: one by one {:.1f} ms, at once {:.1f} ms\n", name, kCameras, one_by_one, at_once);
}

void run(int rounds) {
  {
    std::vector<simulator::GigeCameraOptions> cameras;
    for (std::size_t i = 0; i < kCameras; ++i)
      cameras.push_back({.name = fmt::format("cam{:02}", i),
                         .serial = fmt::format("RS{:04}", i),
                         .address = address_of(i),
                         .mac = {2, 0, 0, 0, 0, static_cast<std::uint8_t>(i)}});
    simulator::GigeStudio studio(cameras, nullptr);
    studio.start();
    print_row("simulated studio", rounds);
  }
  {
    const BareDevices bare(kOneNode);
    print_row("bare devices", rounds);
  }
  const BareDevices described(simulator::genicam_xml({}));
  print_row("bare, our description", rounds);
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 9;
  const sched_param priority{.sched_priority = rotunda::kRealTimePriority};
  if (argc > 2 && sched_setscheduler(0, SCHED_FIFO, &priority) != 0)
    fmt::print(stderr, "open_bench: no real-time priority here\n");
  const auto refusal = rotunda::tests::enter_private_network();
  if (!refusal.empty()) fmt::print(stderr, "open_bench: {}; using the machine's own loopback\n", refusal);
  rotunda::run(rounds);
}
