// How long unmodified Aravis takes to open ten simulated cameras, one after the other and all at once, and what of it
// is Aravis' own: the same with devices that know nothing but what an opening asks for, with a description of one node
// and with the simulated cameras' own. Medians.
//   open_bench [rounds] [realtime]
#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#include "simulator/gige/genicam_xml.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/gige/zip_archive.h"
#include "tests/support/aravis_client.h"
#include "tests/support/bare_device.h"
#include "tests/support/private_network.h"

namespace rotunda {
namespace {

constexpr std::size_t kCameras = 10;
constexpr int kRealTimePriority = 20;

std::string address_of(std::size_t camera) {
  return fmt::format("127.0.0.{}", camera + 1);
}

// Ten that have this description, zipped as cameras have it, and do nothing else.
tests::BareDeviceOptions ten_with(const std::string& description) {
  const auto zipped = simulator::zip_archive("bare.xml", description);
  return {.devices = kCameras,
          .description = {zipped.begin(), zipped.end()},
          .url = fmt::format("Local:bare.zip;{:x};{:x}", tests::BareDevice::kDescription, zipped.size())};
}

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
    const tests::BareDevice bare(ten_with(tests::bare_description("<Category Name=\"Root\"/>")));
    print_row("bare devices", rounds);
  }
  const tests::BareDevice described(ten_with(simulator::genicam_xml({})));
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
