// rotunda plate: records the empty studio.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "config/exit_code.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;

// More than a tape's end or a cable that swings.
constexpr double kMovingTold = 0.002;

void tell(const PlateReport& report) {
  fmt::print("{:<10} {:>8} {:>14} {:>9}\n", "camera", "pictures", "noise (levels)", "moving %");
  for (const auto& camera : report.cameras)
    fmt::print("{:<10} {:>8} {:>14.2f} {:>9.2f}\n", camera.camera, camera.pictures, camera.noise,
               100.0 * camera.moving_share);
  fmt::print("{}: takes recorded from now on keep it\n", report.folder.string());
}

json to_json(const PlateReport& report) {
  json cameras = json::array();
  for (const auto& camera : report.cameras)
    cameras.push_back({{"name", camera.camera},
                       {"file", camera.file.string()},
                       {"pictures", camera.pictures},
                       {"noise", camera.noise},
                       {"moving_share", camera.moving_share}});
  return {{"folder", report.folder.string()}, {"cameras", cameras}, {"missing", report.missing}};
}

int record(const CommandLine& line, std::uint64_t frame_sets) {
  const auto report = RigClient(daemon_socket(line.daemon)).record_plate(frame_sets);
  if (line.json)
    fmt::print("{}\n", to_json(report).dump(2));
  else
    tell(report);
  bool good = report.missing.empty();
  if (!good)
    fmt::print(stderr, "warning: no picture of {}: their plates before, if any, stay\n",
               fmt::join(report.missing, ", "));
  for (const auto& camera : report.cameras)
    if (camera.moving_share > kMovingTold) {
      good = false;
      fmt::print(stderr, "warning: something moved before {}: clear the studio and record the plate again\n",
                 camera.camera);
    }
  return good ? kDone : kDoneWithLoss;
}

}  // namespace

void add_plate_command(CommandLine& line) {
  auto* plate = line.app.add_subcommand("plate", "records the empty studio; takes recorded afterwards keep it");
  auto frame_sets = std::make_shared<std::uint64_t>(50);
  plate->add_option("--frames", *frame_sets, "pictures of each camera to average")->capture_default_str();
  plate->footer("Exit code 1 if something moved meanwhile or a camera is missing.\nExample:\n  rotunda plate");
  plate->callback(
      [&line, frame_sets] { line.run = [&line, frame_sets](std::stop_token) { return record(line, *frame_sets); }; });
}

}  // namespace rotunda::rig
