// rotunda rig init, cameras: what is connected.
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "capture/base/unique_fd.h"
#include "capture/source/source.h"
#include "capture/sync/action_command.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/rig_config.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// Never over another file, not even one that has come meanwhile.
void write_new_file(const fs::path& file, const std::string& text) {
  const capture::UniqueFd made(open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!made || ::write(made.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
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

// 10.0.0.2 before 10.0.0.10; what is no IPv4 address by its letters, behind.
std::pair<std::uint32_t, std::string> in_order_of(const std::string& address) {
  in_addr number{};
  if (inet_pton(AF_INET, address.c_str(), &number) == 1) return {ntohl(number.s_addr), ""};
  return {std::numeric_limits<std::uint32_t>::max(), address};
}

void sort_by_address(std::vector<capture::DiscoveredCamera>& cameras) {
  std::stable_sort(cameras.begin(), cameras.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.kind, in_order_of(a.address)) < std::tuple(b.kind, in_order_of(b.address));
  });
}

// The names that people gave the cameras, where they can name one and name only one; cam00, cam01, ... for the others.
std::vector<std::string> names_for(const std::vector<capture::DiscoveredCamera>& cameras) {
  std::map<std::string, int> given;
  for (const auto& camera : cameras) ++given[camera.user_name];
  std::vector<std::string> names;
  int next = 0;
  for (const auto& camera : cameras) {
    auto name = camera.user_name;
    if (!config::is_camera_name(name) || given[name] > 1) do
        name = fmt::format("cam{:02}", next++);
      while (given.count(name) > 0);
    names.push_back(name);
  }
  return names;
}

config::CameraConfig entry_for(const capture::DiscoveredCamera& found, const std::string& name) {
  config::CameraConfig camera;
  camera.name = name;
  camera.source = found.kind;
  camera.find_by = found.serial.empty() ? "address" : "serial";
  camera.device = found.serial.empty() ? found.address : found.serial;
  if (!found.pixel_format.empty()) camera.pixel_format = found.pixel_format;
  return camera;
}

int init_rig(const fs::path& file) {
  if (fs::exists(file))  // before a second is spent on looking for cameras
    throw InvalidInput(file.string() + " exists already and stays as it is; name another file with -o");
  auto found = capture::discover_cameras();
  if (found.empty())
    throw DeviceError("rig init",
                      "no camera answers; check power, cables and that the cameras share a subnet with "
                      "this machine (rotunda-sim serves simulated ones)");
  sort_by_address(found);
  const auto names = names_for(found);
  config::RigConfig rig;
  rig.name = file.stem().string();
  rig.trigger.interface_address = interface_towards(found.front().address);
  std::vector<std::string> remarks;
  for (std::size_t i = 0; i < found.size(); ++i) {
    rig.cameras.push_back(entry_for(found[i], names[i]));
    remarks.push_back(fmt::format("{} {}, {}", found[i].vendor, found[i].model, found[i].address));
  }
  if (std::all_of(found.begin(), found.end(), [](const auto& camera) { return camera.kind == "v4l2"; }))
    rig.trigger.mode = "freerun";  // they know no trigger that we could give
  write_new_file(file, config::rig_file_text(rig, remarks));
  fmt::print("{}: {} cameras on {}\nnext: rotundad --rig {} --check, and rotunda cameras identify\n", file.string(),
             found.size(), rig.trigger.interface_address, file.string());
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

void add_cameras(CLI::App& parent, CommandLine& line) {
  auto* cameras = parent.add_subcommand("cameras", "lists every camera that answers on this machine's links");
  cameras->footer("Example:\n  rotunda cameras --json\n  rotunda cameras identify -o cameras.png");
  add_identify_command(*cameras, line);
  cameras->callback([&line, cameras] {
    if (cameras->get_subcommands().empty()) line.run = [&line](std::stop_token) { return list_cameras(line.json); };
  });
}

}  // namespace

void add_rig_commands(CommandLine& line) {
  auto* rig = line.app.add_subcommand("rig", "the rig file, its cameras and the daemon")->require_subcommand(1);
  auto* init = rig->add_subcommand("init", "writes a commented rig file with every camera that answers");
  auto file = std::make_shared<fs::path>("rig.yaml");
  init->add_option("-o", *file, "the file to write")->capture_default_str();
  init->footer(
      "Every key stands in it with what it does. Cameras that have a user name keep it. An existing file is left "
      "alone.\n"
      "Example:\n  rotunda rig init -o studio.yaml");
  init->callback([&line, file] { line.run = [file](std::stop_token) { return init_rig(*file); }; });
  add_live_command(*rig, line);
  for (auto* parent : {rig, &line.app}) {  // `rotunda rig status`, and short: `rotunda status`
    add_cameras(*parent, line);
    add_status_command(*parent, line);
  }
}

}  // namespace rotunda::rig
