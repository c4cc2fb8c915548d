#include "rig/machine_facts.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "capture/base/unique_fd.h"
#include "capture/calibration_file.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 4 << 20;

template <class T>
T read_number(const fs::path& file, T otherwise) {
  std::ifstream stream(file);
  T number{};
  return stream >> number ? number : otherwise;
}

std::uint32_t ipv4_of(const sockaddr* address) {
  return ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr);
}

std::vector<Link> links_that_are_up() {
  std::vector<Link> links;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return links;
  for (const auto* entry = first; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || !entry->ifa_netmask || entry->ifa_addr->sa_family != AF_INET) continue;
    if (!(entry->ifa_flags & IFF_UP)) continue;
    const fs::path about = fs::path("/sys/class/net") / entry->ifa_name;
    links.push_back({.name = entry->ifa_name,
                     .address = ipv4_of(entry->ifa_addr),
                     .netmask = ipv4_of(entry->ifa_netmask),
                     .mtu = read_number(about / "mtu", 0),
                     .speed_mbit = std::max(0, read_number(about / "speed", 0)),
                     .loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0});
  }
  freeifaddrs(first);
  return links;
}

// The takes' folder is made with the first take: look at the nearest folder above that is there.
fs::path existing_part(fs::path folder) {
  std::error_code error;
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

DiskFacts disk_facts(const fs::path& takes) {
  DiskFacts disk{.folder = existing_part(takes)};
  disk.writable = access(disk.folder.c_str(), W_OK) == 0;
  std::error_code error;
  const auto space = fs::space(disk.folder, error);
  disk.free_bytes = error ? 0 : space.available;
  return disk;
}

ClockFacts clock_facts() {
  timex answer{};
  const int state = adjtimex(&answer);
  return {.tai_offset_s = answer.tai, .synchronised = state >= 0 && !(answer.status & STA_UNSYNC)};
}

CalibrationFacts calibration_facts(const fs::path& file) {
  CalibrationFacts facts{.file = file};
  try {
    for (const auto& camera : capture::read_calibration(file)) facts.cameras.push_back(camera.name);
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(file);
    facts.age_days = std::chrono::duration<double, std::ratio<86400>>(age).count();
  } catch (const std::exception& error) {
    facts.problem = error.what();
  }
  return facts;
}

std::optional<double> hottest_sensor() {
  std::optional<double> hottest;
  std::error_code error;
  for (const auto& zone : fs::directory_iterator("/sys/class/thermal", error)) {
    const double thousandths = read_number(zone.path() / "temp", -1.0);
    if (thousandths > 0.0) hottest = std::max(hottest.value_or(0.0), thousandths * 1e-3);
  }
  return hottest;
}

}  // namespace

PreflightFacts machine_facts(const fs::path& takes, const std::optional<config::RigConfig>& rig) {
  PreflightFacts facts;
  facts.rig = rig;
  facts.links = links_that_are_up();
  facts.socket_buffer_bytes = read_number<std::uint64_t>("/proc/sys/net/core/rmem_max", 0);
  facts.disk = disk_facts(takes);
  facts.clock = clock_facts();
  if (rig && rig->calibration) facts.calibration = calibration_facts(*rig->calibration);
  facts.hottest_celsius = hottest_sensor();
  return facts;
}

std::optional<double> measure_disk(const fs::path& folder, const DiskTrial& trial) {
  std::error_code error;
  if (const auto space = fs::space(folder, error); error || space.available < 2 * trial.bytes) return std::nullopt;
  auto name = (folder / "rotunda-disk-XXXXXX").string();
  const capture::UniqueFd file(mkostemp(name.data(), O_CLOEXEC));
  if (!file) return std::nullopt;
  unlink(name.c_str());
  const std::vector<char> block(kBlock, 0x5a);
  const auto begun = std::chrono::steady_clock::now();
  std::size_t written = 0;
  while (written < trial.bytes && std::chrono::steady_clock::now() - begun < trial.time) {
    if (!trial.go_on()) return std::nullopt;
    const auto took = ::write(file.get(), block.data(), block.size());
    if (took <= 0) return std::nullopt;
    written += static_cast<std::size_t>(took);
  }
  if (fdatasync(file.get()) != 0) return std::nullopt;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
  return static_cast<double>(written) / spent.count();
}

}  // namespace rotunda::rig
