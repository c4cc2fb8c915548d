// rotunda cameras identify: which is which.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/exit_code.h"
#include "rig/camera_portraits.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

bool daemon_answers(const fs::path& socket) {
  if (!fs::exists(socket)) return false;
  try {
    RigClient(socket).status();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

void tell(const IdentifiedCamera& camera) {
  fmt::print("{:<12} {:<18} {:<16} {:<24} {}{}\n", camera.name, camera.serial, camera.address, camera.model,
             camera.pictured ? "pictured" : "no picture", camera.blinked ? ", blinked its light" : "");
  if (!camera.problem.empty()) fmt::print("             {}\n", camera.problem);
}

int identify(const CommandLine& line, const IdentifyRequest& request, std::stop_token stop) {
  const auto socket = daemon_socket(line.daemon);
  auto absolute = request;
  absolute.picture = fs::absolute(request.picture);
  const auto cameras =
      daemon_answers(socket)
          ? RigClient(socket).identify(absolute)
          : write_contact_sheet(absolute.picture, portraits_by_opening(request.camera, request.blink, std::move(stop)));
  json list = json::array();
  for (const auto& camera : cameras) {
    list.push_back({{"name", camera.name},
                    {"serial", camera.serial},
                    {"address", camera.address},
                    {"model", camera.model},
                    {"pictured", camera.pictured},
                    {"blinked", camera.blinked},
                    {"problem", camera.problem}});
    if (!line.json) tell(camera);
  }
  if (line.json)
    fmt::print("{}\n", json{{"picture", absolute.picture.string()}, {"cameras", list}}.dump(2));
  else
    fmt::print("{}\n", absolute.picture.string());
  const bool all = std::all_of(cameras.begin(), cameras.end(), [](const auto& camera) { return camera.pictured; });
  return all ? kDone : kDoneWithLoss;
}

}  // namespace

void add_identify_command(CLI::App& cameras, CommandLine& line) {
  auto* app = cameras.add_subcommand("identify", "shows which camera is which: a contact sheet with names, and lights");
  auto request = std::make_shared<IdentifyRequest>();
  request->picture = "cameras.png";
  app->add_option("camera", request->camera,
                  "only this one: its name; without a daemon its user name, serial or address");
  app->add_option("-o", request->picture, "the contact sheet, FILE.png")->capture_default_str();
  auto still = std::make_shared<bool>(false);
  app->add_flag("--no-blink", *still, "leave the cameras' lights alone");
  app->footer(
      "One picture of each camera with its name, serial number and address. Cameras with an indicator light blink it.\n"
      "A running daemon makes the pictures (triggering the cameras for a moment, if they are not now); without one "
      "the\n"
      "cameras are opened one after the other. Exit code 1 if a camera gave no picture.\n"
      "Example:\n  rotunda cameras identify\n  rotunda cameras identify cam03 -o which.png");
  app->callback([&line, request, still] {
    request->blink = !*still;
    line.run = [&line, request](std::stop_token stop) { return identify(line, *request, std::move(stop)); };
  });
}

}  // namespace rotunda::rig
