// rotunda rig init, cameras, status: what is connected and how it does.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/base/unique_fd.h"
#include "capture/source/source.h"
#include "capture/sync/action_command.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/rig_config.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

void write_new_file(const fs::path& file, const std::string& text) {
  if (fs::exists(file))
    throw InvalidInput(file.string() + " exists already and stays as it is; name another file with -o");
  std::ofstream stream(file);
  if (!(stream << text)) throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

// This machine's IPv4 address on the way to a camera; connecting a datagram socket asks for the route, sends nothing.
std::string interface_towards(const std::string& camera_address) {
  sockaddr_in camera{};
  camera.sin_family = AF_INET;
  camera.sin_port = htons(capture::gvcp_port);
  if (inet_pton(AF_INET, camera_address.c_str(), &camera.sin_addr) != 1) return "127.0.0.1";
  const capture::UniqueFd probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in own{};
  socklen_t length = sizeof own;
  if (connect(probe.get(), reinterpret_cast<const sockaddr*>(&camera), sizeof camera) != 0 ||
      getsockname(probe.get(), reinterpret_cast<sockaddr*>(&own), &length) != 0)
    return "127.0.0.1";
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &own.sin_addr, text, sizeof text);
  return text;
}

int init_rig(const fs::path& file) {
  const auto found = capture::discover_cameras();
  if (found.empty())
    throw DeviceError("rig init",
                      "no camera answers; check power, cables and that the cameras share a subnet with "
                      "this machine (rotunda-sim serves simulated ones)");
  config::RigConfig rig;
  rig.name = file.stem().string();
  rig.trigger.interface_address = interface_towards(found.front().address);
  for (std::size_t i = 0; i < found.size(); ++i) {
    config::CameraConfig camera;
    camera.name = fmt::format("cam{:02}", i);
    camera.source = found[i].kind;
    camera.find_by = found[i].serial.empty() ? "address" : "serial";
    camera.device = found[i].serial.empty() ? found[i].address : found[i].serial;
    if (!found[i].pixel_format.empty()) camera.pixel_format = found[i].pixel_format;
    rig.cameras.push_back(camera);
  }
  if (std::all_of(found.begin(), found.end(), [](const auto& camera) { return camera.kind == "v4l2"; }))
    rig.trigger.mode = "freerun";  // they know no trigger that we could give
  write_new_file(file, config::rig_file_text(rig));
  fmt::print("{}: {} cameras\nnext: rotundad --rig {}\n", file.string(), found.size(), file.string());
  return kDone;
}

int list_cameras(bool as_json) {
  const auto found = capture::discover_cameras();
  json cameras = json::array();
  for (const auto& camera : found)
    cameras.push_back({{"kind", camera.kind},
                       {"address", camera.address},
                       {"serial", camera.serial},
                       {"user_name", camera.user_name},
                       {"vendor", camera.vendor},
                       {"model", camera.model},
                       {"mac", camera.mac},
                       {"pixel_format", camera.pixel_format}});
  if (as_json) {
    fmt::print("{}\n", json{{"cameras", cameras}}.dump(2));
    return kDone;
  }
  fmt::print("{:<8} {:<16} {:<18} {:<12} {}\n", "kind", "address", "serial", "name", "model");
  for (const auto& camera : found)
    fmt::print("{:<8} {:<16} {:<18} {:<12} {} {}\n", camera.kind, camera.address, camera.serial, camera.user_name,
               camera.vendor, camera.model);
  if (found.empty()) fmt::print("no camera answers\n");
  return kDone;
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
            {"failure", status.take.failure}}},
          {"late_triggers", status.late_triggers},
          {"late_frames", status.late_frames},
          {"queued_frame_sets", status.queued_frame_sets},
          {"warnings", status.warnings},
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

void print_status(const RigStatus& status) {
  fmt::print("{}: {}, trigger {} at {} Hz, takes in {}, {:.1f} min of recording left\n", status.rig, status.state,
             status.trigger, status.rate_hz, status.takes_folder.string(), status.seconds_left / 60.0);
  if (!status.take.name.empty())
    fmt::print("take {}: {} frame sets, {} complete{}\n", status.take.name, status.take.frame_sets,
               status.take.complete, status.take.closed ? "" : ", recording");
  for (const auto& warning : status.warnings) fmt::print("warning: {}\n", warning);
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

void add_cameras(CLI::App& parent, CommandLine& line) {
  auto* cameras = parent.add_subcommand("cameras", "lists every camera that answers on this machine's links");
  cameras->footer("Example:\n  rotunda cameras --json");
  cameras->callback([&line] { line.run = [&line](std::stop_token) { return list_cameras(line.json); }; });
}

void add_live(CLI::App& parent, CommandLine& line) {
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

void add_status(CLI::App& parent, CommandLine& line) {
  auto* status = parent.add_subcommand("status", "how the daemon, its cameras and the running take do");
  status->footer("Example:\n  rotunda status");
  status->callback([&line] {
    line.run = [&line](std::stop_token) {
      return tell_status(RigClient(daemon_socket(line.daemon)).status(), line.json);
    };
  });
}

}  // namespace

void add_rig_commands(CommandLine& line) {
  auto* rig = line.app.add_subcommand("rig", "the rig file, its cameras and the daemon")->require_subcommand(1);
  auto* init = rig->add_subcommand("init", "writes a rig file with every camera that answers");
  auto file = std::make_shared<fs::path>("rig.yaml");
  init->add_option("-o", *file, "the file to write")->capture_default_str();
  init->footer("Example:\n  rotunda rig init -o studio.yaml");
  init->callback([&line, file] { line.run = [file](std::stop_token) { return init_rig(*file); }; });
  add_live(*rig, line);
  for (auto* parent : {rig, &line.app}) {  // `rotunda rig status`, and short: `rotunda status`
    add_cameras(*parent, line);
    add_status(*parent, line);
  }
}

}  // namespace rotunda::rig
