// rotunda doctor: what of this machine would cost frames, and the cure.
#include <fcntl.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "capture/base/unique_fd.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "playback/render/gl_objects.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;

enum class Verdict { good, note, look };  // note: costs something only if cameras hang on it

struct Finding {
  std::string what;
  Verdict verdict = Verdict::look;
  std::string measured;
  std::string cure;
};

Verdict good_if(bool good) {
  return good ? Verdict::good : Verdict::look;
}

const char* to_string(Verdict verdict) {
  if (verdict == Verdict::good) return "good";
  return verdict == Verdict::note ? "note" : "LOOK";
}

// One camera's burst at full rate while its reader is held up for a few frames.
constexpr long kSocketBuffer = 4 << 20;
// Ten 720 x 576 cameras at 25 Hz write 104 MB/s; the disk must do it with room to spare.
constexpr double kDiskRate = 150e6;
constexpr int kJumboMtu = 8900;

Finding socket_buffers() {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  long granted = 0;
  file >> granted;
  return {"socket buffers", good_if(granted >= kSocketBuffer), fmt::format("net.core.rmem_max = {}", granted),
          "as root: cp config/sysctl.d/60-rotunda.conf /etc/sysctl.d/ && sysctl --system"};
}

int mtu_of(const std::string& interface) {
  const capture::UniqueFd probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return ioctl(probe.get(), SIOCGIFMTU, &request) == 0 ? request.ifr_mtu : 0;
}

std::vector<Finding> link_mtus() {
  std::vector<Finding> findings;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return findings;
  for (auto* entry = first; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET || !(entry->ifa_flags & IFF_UP)) continue;
    const int mtu = mtu_of(entry->ifa_name);
    findings.push_back({fmt::format("link {}", entry->ifa_name), mtu >= kJumboMtu ? Verdict::good : Verdict::note,
                        fmt::format("MTU {}", mtu),
                        fmt::format("if cameras hang on it: ip link set {} mtu 9000 (and on the switch); without it "
                                    "capture costs six times the CPU",
                                    entry->ifa_name)});
  }
  freeifaddrs(first);
  return findings;
}

Finding disk_speed(const fs::path& takes) {
  fs::path folder = takes;
  while (!fs::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  auto name = (folder / "rotunda-doctor-XXXXXX").string();
  const capture::UniqueFd file(mkstemp(name.data()));
  const auto what = "disk of " + folder.string();
  if (!file)
    return {what, Verdict::look, "cannot be written", "give this user the right to write there, or set --takes"};
  unlink(name.c_str());
  const std::vector<char> block(4 << 20, 0x5a);
  constexpr int kBlocks = 48;
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < kBlocks; ++i)
    if (::write(file.get(), block.data(), block.size()) < 0) return {what, Verdict::look, "is full", "free some space"};
  fdatasync(file.get());
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
  const double rate = static_cast<double>(block.size()) * kBlocks / spent.count();
  return {
      what, good_if(rate >= kDiskRate),
      fmt::format("{:.0f} MB/s, {:.0f} GB free", rate / 1e6, static_cast<double>(fs::space(folder).available) / 1e9),
      "ten cameras at 25 Hz write 104 MB/s: record to a faster disk with --takes"};
}

Finding display() {
  try {
    const playback::HeadlessDisplay headless;
    const playback::RenderTarget target(64, 64);
    return {"renderer", Verdict::good, reinterpret_cast<const char*>(glGetString(GL_RENDERER)), ""};
  } catch (const DeviceError& error) {
    return {"renderer", Verdict::look, error.what(), "apt-get install libgl1-mesa-dri"};
  }
}

int examine(const CommandLine& line) {
  auto findings = link_mtus();
  findings.insert(findings.begin(), socket_buffers());
  findings.push_back(disk_speed(takes_folder(line)));
  findings.push_back(display());
  nlohmann::json report = nlohmann::json::array();
  for (const auto& finding : findings) {
    const bool good = finding.verdict == Verdict::good;
    report.push_back({{"what", finding.what},
                      {"verdict", to_string(finding.verdict)},
                      {"measured", finding.measured},
                      {"cure", good ? "" : finding.cure}});
    if (line.json) continue;
    fmt::print("{:<5} {:<24} {}\n", to_string(finding.verdict), finding.what, finding.measured);
    if (!good) fmt::print("      -> {}\n", finding.cure);
  }
  if (line.json) fmt::print("{}\n", nlohmann::json{{"checks", report}}.dump(2));
  const bool look =
      std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.verdict == Verdict::look; });
  return look ? kDoneWithLoss : kDone;
}

}  // namespace

void add_doctor_command(CommandLine& line) {
  auto* doctor = line.app.add_subcommand("doctor", "checks this machine: socket buffers, MTU, disk speed, renderer");
  doctor->footer("Example:\n  rotunda doctor\nExit code 1 if something should be looked at.");
  doctor->callback([&line] { line.run = [&line](std::stop_token) { return examine(line); }; });
}

}  // namespace rotunda::rig
