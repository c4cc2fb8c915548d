// rotunda status, rotunda rig live: how the daemon, its cameras and the running take do.
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/exit_code.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"
#include "rig/preflight.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;

json to_json(const std::vector<Finding>& findings) {
  json list = json::array();
  for (const auto& finding : findings)
    list.push_back({{"what", finding.what},
                    {"verdict", to_string(finding.verdict)},
                    {"measured", finding.measured},
                    {"cure", finding.cure}});
  return list;
}

json to_json(const LiveSurfacesStatus& surfaces) {
  return {{"state", surfaces.state},         {"rate_hz", surfaces.rate_hz}, {"delay_ms", surfaces.delay_ms},
          {"made", surfaces.made},           {"shed", surfaces.shed},       {"failed", surfaces.failed},
          {"triangles", surfaces.triangles}, {"viewers", surfaces.viewers}, {"problem", surfaces.problem}};
}

json to_json(const RigStatus& status) {
  json cameras = json::array();
  for (const auto& camera : status.cameras)
    cameras.push_back({{"name", camera.name},
                       {"device", camera.device},
                       {"state", camera.state},
                       {"model", camera.model},
                       {"serial", camera.serial},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"pixel_format", camera.pixel_format},
                       {"frames", camera.frames},
                       {"incomplete", camera.incomplete},
                       {"dropped", camera.dropped},
                       {"resend_requests", camera.resend_requests},
                       {"packet_size", camera.packet_size},
                       {"socket_buffer_bytes", camera.socket_buffer_bytes},
                       {"rate_hz", camera.rate_hz},
                       {"missing", camera.missing},
                       {"clipped", camera.clipped ? json(*camera.clipped) : json()},
                       {"focus", camera.focus ? json(*camera.focus) : json()},
                       {"clock", camera.clock ? json(*camera.clock) : json()},
                       {"clock_offset_us", camera.clock_offset_us ? json(*camera.clock_offset_us) : json()},
                       {"clock_error_us", camera.clock_error_us ? json(*camera.clock_error_us) : json()},
                       {"temperature_c", camera.temperature_c ? json(*camera.temperature_c) : json()},
                       {"silent_s", camera.silent_s},
                       {"address", camera.address},
                       {"offset_us", camera.offset_us ? json(*camera.offset_us) : json()},
                       {"drift_ppm", camera.drift_ppm ? json(*camera.drift_ppm) : json()},
                       {"problem", camera.problem}});
  return {{"rig", status.rig},
          {"state", status.state},
          {"trigger", status.trigger},
          {"rate_hz", status.rate_hz},
          {"takes_folder", status.takes_folder.string()},
          {"disk_free_bytes", status.disk_free_bytes},
          {"seconds_left", status.seconds_left},
          {"take",
           {{"name", status.take.name},
            {"frame_sets", status.take.frame_sets},
            {"complete", status.take.complete},
            {"closed", status.take.closed},
            {"slate", status.take.slate},
            {"note", status.take.note},
            {"circled", status.take.circled},
            {"marks", status.take.marks},
            {"failure", status.take.failure}}},
          {"late_triggers", status.late_triggers},
          {"late_frames", status.late_frames},
          {"queued_frame_sets", status.queued_frame_sets},
          {"warnings", status.warnings},
          {"preflight", to_json(status.preflight)},
          {"surfaces", to_json(status.surfaces)},
          {"cannot_record", why_not_record(status.preflight)},
          {"cameras", cameras}};
}

std::string percent(const std::optional<double>& share) {
  return share ? fmt::format("{:.1f}", 100.0 * *share) : "-";
}

// "3 late, 1 packets lost"
std::string causes(const std::map<std::string, std::uint64_t>& missing) {
  std::string text;
  for (const auto& [why, frames] : missing) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", frames, why);
  return text;
}

void print_surfaces(const LiveSurfacesStatus& surfaces) {
  if (surfaces.state != "running") return;
  fmt::print(
      "surfaces: {:.1f} a second, {:.0f} ms after their triggers; {} made, {} frame sets shed, {} without one, {} "
      "watch\n",
      surfaces.rate_hz, surfaces.delay_ms, surfaces.made, surfaces.shed, surfaces.failed, surfaces.viewers);
  if (!surfaces.problem.empty()) fmt::print("          {}\n", surfaces.problem);
}

void print_status(const RigStatus& status) {
  fmt::print("{}: {}, trigger {} at {} Hz, takes in {}, {:.1f} min of recording left\n", status.rig, status.state,
             status.trigger, status.rate_hz, status.takes_folder.string(), status.seconds_left / 60.0);
  if (!status.take.name.empty())
    fmt::print("take {}: {} frame sets, {} complete{}\n", status.take.name, status.take.frame_sets,
               status.take.complete, status.take.closed ? "" : ", recording");
  print_surfaces(status.surfaces);
  for (const auto& reason : why_not_record(status.preflight)) fmt::print("cannot record: {}\n", reason);
  for (const auto& warning : status.warnings) fmt::print("warning: {}\n", warning);
  for (const auto& finding : status.preflight)
    if (finding.verdict == Verdict::look)
      fmt::print("look: {}: {}\n      -> {}\n", finding.what, finding.measured, finding.cure);
  fmt::print("\n{:<8} {:<16} {:<10} {:>11} {:<10} {:>6} {:>8} {:>8} {:>8} {:>6} {:>6}  {}\n", "camera", "device",
             "state", "size", "format", "Hz", "frames", "dropped", "resends", "clip %", "focus", "missing");
  for (const auto& camera : status.cameras) {
    fmt::print("{:<8} {:<16} {:<10} {:>11} {:<10} {:>6.1f} {:>8} {:>8} {:>8} {:>6} {:>6}  {}\n", camera.name,
               camera.device, camera.state, fmt::format("{}x{}", camera.width, camera.height), camera.pixel_format,
               camera.rate_hz, camera.frames, camera.dropped, camera.resend_requests, percent(camera.clipped),
               percent(camera.focus), causes(camera.missing));
    if (!camera.problem.empty()) fmt::print("         {}\n", camera.problem);
  }
}

int tell_status(const RigStatus& status, bool as_json) {
  if (as_json)
    fmt::print("{}\n", to_json(status).dump(2));
  else
    print_status(status);
  return kDone;
}

}  // namespace

void add_live_command(CLI::App& parent, CommandLine& line) {
  auto* live = parent.add_subcommand("live", "triggers the cameras and watches their pictures without recording");
  auto off = std::make_shared<bool>(false);
  live->add_flag("--off", *off, "no longer");
  live->footer(
      "Exposure and focus of every camera are then in `rotunda status`; takes can be started all the same.\n"
      "Example:\n  rotunda rig live");
  live->callback([&line, off] {
    line.run = [&line, off](std::stop_token) {
      return tell_status(RigClient(daemon_socket(line.daemon)).set_live(!*off), line.json);
    };
  });
}

void add_status_command(CLI::App& parent, CommandLine& line) {
  auto* status = parent.add_subcommand("status", "how the daemon, its cameras and the running take do");
  status->footer("Example:\n  rotunda status");
  status->callback([&line] {
    line.run = [&line](std::stop_token) {
      return tell_status(RigClient(daemon_socket(line.daemon)).status(), line.json);
    };
  });
}

}  // namespace rotunda::rig
