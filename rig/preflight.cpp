#include "rig/preflight.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "capture/frame.h"
#include "capture/sync/bandwidth_plan.h"

namespace rotunda::rig {
namespace {

using Findings = std::vector<Finding>;

// One camera's burst at full rate while its reader is held up for a few frames.
constexpr std::uint64_t kSocketBuffer = 4 << 20;
// Ten 720 x 576 cameras at 25 Hz: what a rig writes when none is named.
constexpr double kUsualRate = 104e6;
// A disk that is just fast enough is too slow as soon as it does anything else.
constexpr double kDiskMargin = 1.4;
constexpr int kJumboMtu = 8900;
constexpr double kShortTime_s = 600.0;
constexpr double kOldCalibration_days = 30.0;
constexpr double kHot_celsius = 90.0;
constexpr double kHotCamera_celsius = 75.0;  // inside; most are made for 50 to 65 outside
constexpr double kOffset_us = 1000.0;        // from its trigger; a moving hand blurs over 1 ms at 2 m/s by 2 mm
constexpr double kSpread_us = 1000.0;
constexpr int kDefaultMtu = 1500;

Finding good(std::string what, std::string measured) {
  return {std::move(what), Verdict::good, std::move(measured), ""};
}

const CameraStatus* status_of(const PreflightFacts& facts, const std::string& camera) {
  if (!facts.status) return nullptr;
  const auto& cameras = facts.status->cameras;
  const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const auto& c) { return c.name == camera; });
  return found == cameras.end() ? nullptr : &*found;
}

double frame_bytes(const PreflightFacts& facts, const config::CameraConfig& camera) {
  const auto* told = status_of(facts, camera.name);
  const bool knows = told && told->width > 0;
  const auto format = capture::pixel_format_from(knows ? told->pixel_format : camera.pixel_format);
  if (!format) return 0.0;
  const int width = knows ? static_cast<int>(told->width) : camera.width;
  const int height = knows ? static_cast<int>(told->height) : camera.height;
  return static_cast<double>(capture::image_bytes(width, height, *format));
}

void check_cameras(const PreflightFacts& facts, Findings& findings) {
  if (!facts.status) return;
  std::size_t streaming = 0;
  for (const auto& camera : facts.status->cameras) {
    if (camera.state == "streaming") {
      ++streaming;
      continue;
    }
    findings.push_back({"camera " + camera.name, Verdict::look,
                        fmt::format("{}{}{}", camera.state, camera.problem.empty() ? "" : ": ", camera.problem),
                        "check its cable and power; recording goes on without it and leaves holes"});
  }
  const auto all = facts.status->cameras.size();
  const auto count = fmt::format("{} of {} stream", streaming, all);
  if (streaming == 0)
    findings.push_back(
        {"cameras", Verdict::stop, "none streams", "power, cables, addresses; see who answers with: rotunda cameras"});
  else if (streaming == all)
    findings.push_back(good("cameras", count));
}

void check_trigger(const PreflightFacts& facts, Findings& findings) {
  if (!facts.status || !facts.rig) return;
  if (facts.rig->trigger.mode == facts.status->trigger) return;
  findings.push_back({"trigger", Verdict::look,
                      fmt::format("{} where the rig file says {}", facts.status->trigger, facts.rig->trigger.mode),
                      "a camera knows no scheduled actions: give it an own rig, or set trigger.mode to software"});
}

void check_disk_room(const PreflightFacts& facts, Findings& findings) {
  const auto what = "disk of " + facts.disk.folder.string();
  if (!facts.disk.writable) {
    findings.push_back({what, Verdict::stop, "cannot be written",
                        "give this user the right to write there, or name another folder with --takes"});
    return;
  }
  const double free = static_cast<double>(facts.disk.free_bytes);
  const double reserve = facts.rig ? facts.rig->storage.reserve_mb * 1e6 : 0.0;
  const double rate = bytes_per_second(facts);
  const double seconds = std::max(0.0, free - reserve) / (rate > 0.0 ? rate : kUsualRate);
  const auto measured = fmt::format("{:.1f} GB free, {:.0f} min of recording", free * 1e-9, std::floor(seconds / 60.0));
  if (facts.rig && free <= reserve)
    findings.push_back({what, Verdict::stop,
                        fmt::format("{:.0f} MB free, and storage.reserve_mb keeps {:.0f}", free * 1e-6, reserve * 1e-6),
                        "move takes away, or name another disk with --takes"});
  else if (seconds < kShortTime_s)
    findings.push_back({what, Verdict::look, measured, "move takes away, or name another disk with --takes"});
  else
    findings.push_back(good(what, measured));
}

void check_disk_speed(const PreflightFacts& facts, Findings& findings) {
  if (!facts.disk.bytes_per_second) return;
  const double rate = bytes_per_second(facts);
  const double needed = rate > 0.0 ? rate : kUsualRate;
  const auto measured = fmt::format("writes {:.0f} MB/s", *facts.disk.bytes_per_second * 1e-6);
  if (*facts.disk.bytes_per_second >= kDiskMargin * needed) {
    findings.push_back(good("disk speed", measured));
    return;
  }
  findings.push_back({"disk speed", Verdict::look, measured,
                      fmt::format("{} {:.0f} MB/s and more to spare: record to a faster disk with --takes",
                                  rate > 0.0 ? "this rig needs" : "ten cameras at 25 Hz need", needed * 1e-6)});
}

void check_socket_buffers(const PreflightFacts& facts, Findings& findings) {
  findings.push_back({"socket buffers", facts.socket_buffer_bytes >= kSocketBuffer ? Verdict::good : Verdict::look,
                      fmt::format("net.core.rmem_max = {}", facts.socket_buffer_bytes),
                      facts.socket_buffer_bytes >= kSocketBuffer
                          ? ""
                          : "as root: cp config/sysctl.d/60-rotunda.conf /etc/sysctl.d/ && sysctl --system"});
}

std::optional<std::uint32_t> ipv4(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
  return ntohl(address.s_addr);
}

const Link* link_towards(const std::vector<Link>& links, std::uint32_t address) {
  const Link* best = nullptr;
  for (const auto& link : links)
    if ((address & link.netmask) == (link.address & link.netmask) && (!best || link.netmask > best->netmask))
      best = &link;
  return best;
}

// Where a camera hangs: by its own address if that is known, else on the link that the rig file names.
const Link* link_of(const PreflightFacts& facts, const config::CameraConfig& camera) {
  const auto* told = status_of(facts, camera.name);
  auto address = ipv4(told && !told->address.empty() ? told->address : camera.device);
  if (!address) address = ipv4(facts.rig->trigger.interface_address);
  return address ? link_towards(facts.links, *address) : nullptr;
}

std::string count(std::size_t cameras) {
  return fmt::format("{} camera{}", cameras, cameras == 1 ? "" : "s");
}

capture::LinkLoad load_of(const PreflightFacts& facts, const config::CameraConfig& camera, const Link& link) {
  const auto* told = status_of(facts, camera.name);
  const int of_link = std::min(link.mtu > 0 ? link.mtu : kDefaultMtu, kJumboMtu);
  const int asked = camera.packet_size > 0 ? camera.packet_size : of_link;
  return {.camera = camera.name,
          .link = link.name,
          .frame_bytes = static_cast<std::size_t>(frame_bytes(facts, camera)),
          .packet_size = told && told->packet_size > 0 ? static_cast<int>(told->packet_size) : asked};
}

std::vector<capture::LinkLoad> loads_of(const PreflightFacts& facts, Findings& findings) {
  std::vector<capture::LinkLoad> loads;
  std::vector<std::string> nowhere;
  for (const auto& camera : facts.rig->cameras) {
    if (camera.source != config::CameraConfig{}.source) continue;  // others hang on no network
    if (const auto* link = link_of(facts, camera))
      loads.push_back(load_of(facts, camera, *link));
    else
      nowhere.push_back(camera.name);
  }
  if (!nowhere.empty())
    findings.push_back({"links", Verdict::look,
                        fmt::format("no link of this machine leads to {}", fmt::join(nowhere, ", ")),
                        "give the link an address in the cameras' subnet, and set trigger.interface to it"});
  return loads;
}

// The same plan by which takes are refused (capture/sync/bandwidth_plan.h).
void check_bandwidth(const PreflightFacts& facts, const std::vector<capture::LinkLoad>& loads, Findings& findings) {
  std::map<std::string, double> speeds;
  for (const auto& link : facts.links)
    if (link.speed_mbit > 0) speeds[link.name] = link.speed_mbit * 1e6;
  for (const auto& link : capture::plan_bandwidth(loads, speeds, facts.rig->trigger.rate_hz).links)
    findings.push_back({"link " + link.link, link.fits ? Verdict::good : Verdict::stop,
                        link.arithmetic.substr(link.link.size() + 2),
                        link.fits ? "" : "a take is refused until they fit"});
  for (const auto& link : facts.links) {
    const auto on_it = std::count_if(loads.begin(), loads.end(), [&](const auto& l) { return l.link == link.name; });
    if (on_it > 0 && link.speed_mbit <= 0)
      findings.push_back(good("link " + link.name, count(static_cast<std::size_t>(on_it)) + ", no limit known"));
  }
}

void check_mtu(const Link& link, bool has_cameras, Findings& findings) {
  const auto what = "MTU of " + link.name;
  const auto measured = fmt::format("{} bytes", link.mtu);
  if (link.mtu >= kJumboMtu) return findings.push_back(good(what, measured));
  findings.push_back({what, Verdict::note, measured,
                      fmt::format("{}ip link set {} mtu 9000 (and on the switch); without it capture costs six times "
                                  "the CPU",
                                  has_cameras ? "" : "if cameras hang on it: ", link.name)});
}

void check_links(const PreflightFacts& facts, Findings& findings) {
  if (!facts.rig) {
    for (const auto& link : facts.links) check_mtu(link, false, findings);
    return;
  }
  const auto loads = loads_of(facts, findings);
  check_bandwidth(facts, loads, findings);
  for (const auto& link : facts.links)
    if (std::any_of(loads.begin(), loads.end(), [&](const auto& load) { return load.link == link.name; }))
      check_mtu(link, true, findings);
}

bool simulated(const PreflightFacts& facts) {
  const auto interface = facts.rig ? ipv4(facts.rig->trigger.interface_address) : std::nullopt;
  return interface && (*interface >> 24) == 127;
}

void check_host_clock(const PreflightFacts& facts, Findings& findings) {
  const auto measured =
      fmt::format("{}, TAI is UTC + {} s", facts.clock.synchronised ? "synchronised" : "nothing disciplines it",
                  facts.clock.tai_offset_s);
  if (facts.clock.synchronised && facts.clock.tai_offset_s != 0) return findings.push_back(good("clock", measured));
  findings.push_back({"clock", Verdict::note, measured,
                      simulated(facts)
                          ? "simulated cameras follow it as it is"
                          : "cameras on PTP follow TAI: run ptp4l and phc2sys (or chrony, for the host's own "
                            "time), which also tell the kernel the TAI offset"});
}

void check_camera_clocks(const PreflightFacts& facts, Findings& findings) {
  if (!facts.status) return;
  std::vector<std::string> off, unsure;
  for (const auto& camera : facts.status->cameras) {
    if (camera.offset_us && std::abs(*camera.offset_us) > kOffset_us)
      off.push_back(fmt::format("{} by {:+.1f} ms", camera.name, *camera.offset_us * 1e-3));
    if (camera.clock_error_us.value_or(0.0) > kOffset_us)
      unsure.push_back(fmt::format("{} by {:.1f} ms ({})", camera.name, *camera.clock_error_us * 1e-3,
                                   camera.clock.value_or("clock unknown")));
  }
  if (!unsure.empty())
    findings.push_back({"camera time stamps", Verdict::look, fmt::format("may be wrong: {}", fmt::join(unsure, ", ")),
                        "switch on PTP in these cameras, and see that one master serves all of them"});
  const double spread = facts.status->spread_p99_us;
  if (!off.empty())
    findings.push_back({"camera clocks", Verdict::look, fmt::format("off their triggers: {}", fmt::join(off, ", ")),
                        "switch on PTP in these cameras, and see that one master serves all of them"});
  else if (spread > kSpread_us)
    findings.push_back({"camera clocks", Verdict::look,
                        fmt::format("exposures of a frame set start up to {:.1f} ms apart", spread * 1e-3),
                        "trigger by action or by the trigger box instead of software, or check the cameras' PTP"});
  else if (spread > 0.0)
    findings.push_back(good("camera clocks", fmt::format("exposures start within {:.0f} us", spread)));
}

void check_calibration(const PreflightFacts& facts, Findings& findings) {
  if (!facts.rig) return;
  const auto look = [&](const std::string& measured, const std::string& cure) {
    findings.push_back({"calibration", Verdict::look, measured, cure});
  };
  if (!facts.calibration)
    return look("the rig file names none", "takes cannot be reconstructed without: set calibration: FILE");
  const auto& known = facts.calibration->cameras;
  if (!facts.calibration->problem.empty())
    return look(facts.calibration->problem, "recording goes on; calibrate before takes are reconstructed");
  std::vector<std::string> missing;
  for (const auto& camera : facts.rig->cameras)
    if (std::find(known.begin(), known.end(), camera.name) == known.end()) missing.push_back(camera.name);
  if (!missing.empty())
    return look(fmt::format("{} does not know {}", facts.calibration->file.string(), fmt::join(missing, ", ")),
                "calibrate the rig as it stands, or give its cameras the names that the file has");
  const auto age = fmt::format("{} cameras, {:.0f} days old", known.size(), std::floor(facts.calibration->age_days));
  if (facts.calibration->age_days > kOldCalibration_days)
    findings.push_back({"calibration", Verdict::note, age, "a tripod that was touched since is worth a new one"});
  else
    findings.push_back(good("calibration", age));
}

void check_temperature(const PreflightFacts& facts, Findings& findings) {
  std::vector<std::string> hot, told;
  if (facts.hottest_celsius) {
    auto& list = *facts.hottest_celsius > kHot_celsius ? hot : told;
    list.push_back(fmt::format("this machine {:.0f}", *facts.hottest_celsius));
  }
  for (const auto& camera : facts.status ? facts.status->cameras : std::vector<CameraStatus>{})
    if (camera.temperature_c) {
      auto& list = *camera.temperature_c > kHotCamera_celsius ? hot : told;
      list.push_back(fmt::format("{} {:.0f}", camera.name, *camera.temperature_c));
    }
  if (!hot.empty())
    findings.push_back({"temperature", Verdict::look, fmt::format("{} degrees", fmt::join(hot, ", ")),
                        "give them air: a hot camera's pictures get noisy and it stops, a hot machine gets slow"});
  else if (!told.empty())
    findings.push_back(good("temperature", fmt::format("{} degrees", fmt::join(told, ", "))));
}

void check_renderer(const PreflightFacts& facts, Findings& findings) {
  if (!facts.renderer) return;
  if (facts.renderer->problem.empty()) return findings.push_back(good("renderer", facts.renderer->name));
  findings.push_back({"renderer", Verdict::look, facts.renderer->problem, "apt-get install libgl1-mesa-dri"});
}

struct Row {
  const char* about;
  void (*check)(const PreflightFacts&, Findings&);
};

constexpr std::array kTable{
    Row{"cameras that are missing", check_cameras},
    Row{"the trigger in force", check_trigger},
    Row{"room for takes", check_disk_room},
    Row{"the disk's speed", check_disk_speed},
    Row{"what the kernel keeps for a busy reader", check_socket_buffers},
    Row{"links, what they carry, MTU", check_links},
    Row{"this machine's clock", check_host_clock},
    Row{"the cameras' clocks", check_camera_clocks},
    Row{"the calibration", check_calibration},
    Row{"temperature", check_temperature},
    Row{"what draws", check_renderer},
};

}  // namespace

double bytes_per_second(const PreflightFacts& facts) {
  if (!facts.rig) return 0.0;
  double bytes = 0.0;
  for (const auto& camera : facts.rig->cameras) bytes += frame_bytes(facts, camera);
  return bytes * facts.rig->trigger.rate_hz;
}

std::vector<Finding> preflight(const PreflightFacts& facts) {
  Findings findings;
  for (const auto& row : kTable) row.check(facts, findings);
  return findings;
}

std::vector<std::string> why_not_record(const std::vector<Finding>& findings) {
  std::vector<std::string> reasons;
  for (const auto& finding : findings)
    if (finding.verdict == Verdict::stop)
      reasons.push_back(fmt::format("{}: {}; {}", finding.what, finding.measured, finding.cure));
  return reasons;
}

}  // namespace rotunda::rig
