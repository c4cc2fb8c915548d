#pragma once
// Why the rig cannot record, or would lose frames, in words with the cure. Each check is a row of one table, shared by
// `rotunda doctor`, `rotundad --check` and the running daemon. The checks are pure: what they look at is gathered
// beforehand (rig/machine_facts.h). Bytes and bits are decimal (MB = 10^6).
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/finding.h"

namespace rotunda::rig {

// A network link of this machine with an IPv4 address.
struct Link {
  std::string name;       // "eth0"
  std::uint32_t address;  // of this machine, host byte order
  std::uint32_t netmask;
  int mtu = 0;         // bytes
  int speed_mbit = 0;  // 0: it does not tell (loopback, virtual links)
  bool loopback = false;
};

struct DiskFacts {
  std::filesystem::path folder;  // the takes', or the nearest above it that exists
  bool writable = true;
  std::uint64_t free_bytes = 0;
  std::optional<double> bytes_per_second;  // of writing; nothing: not measured
};

struct ClockFacts {
  int tai_offset_s = 0;       // TAI less UTC as the kernel knows it; 0: nobody told it
  bool synchronised = false;  // something (NTP, PTP) disciplines the kernel's clock
};

struct CalibrationFacts {
  std::filesystem::path file;
  std::string problem;  // why it cannot be read; empty if it can
  std::vector<std::string> cameras;
  double age_days = 0.0;
};

struct RendererFacts {
  std::string name;     // of the GL renderer
  std::string problem;  // why there is none
};

struct PreflightFacts {
  std::optional<config::RigConfig> rig;  // nothing: the machine alone is looked at
  std::optional<RigStatus> status;       // nothing: no daemon tells of its cameras
  std::vector<Link> links;
  std::uint64_t socket_buffer_bytes = 0;  // the largest that the kernel grants
  DiskFacts disk;
  ClockFacts clock;
  std::optional<CalibrationFacts> calibration;  // nothing: the rig file names none
  std::optional<double> hottest_celsius;        // of this machine's sensors
  std::optional<RendererFacts> renderer;        // nothing: nobody draws here
};

// What the rig writes, by the cameras' own sizes where they told them, else by the rig file's; 0 if nobody knows.
double bytes_per_second(const PreflightFacts& facts);

// Every row's findings in the table's order, good ones too.
std::vector<Finding> preflight(const PreflightFacts& facts);

// The findings that keep the rig from recording, as sentences; empty if it can.
std::vector<std::string> why_not_record(const std::vector<Finding>& findings);

}  // namespace rotunda::rig
