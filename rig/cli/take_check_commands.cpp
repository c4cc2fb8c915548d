// rotunda take verify | recover: is what was recorded there, and as it was.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "capture/calibration/take_watch.h"
#include "capture/take/take_recovery.h"
#include "capture/take/take_verify.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json to_json(const capture::TakeReport& report) {
  json cameras = json::array(), gaps = json::array();
  for (const auto& camera : report.cameras)
    cameras.push_back(
        {{"name", camera.name}, {"frames", camera.frames}, {"missing", camera.missing}, {"corrupt", camera.corrupt}});
  for (const auto& gap : report.gaps)
    gaps.push_back({{"camera", gap.camera}, {"first_trigger", gap.first_trigger}, {"frames", gap.frames}});
  return {{"name", report.name},
          {"state", to_string(report.state)},
          {"frame_sets", report.frame_sets},
          {"complete", report.complete},
          {"incomplete", report.incomplete},
          {"cameras", cameras},
          {"gaps", gaps},
          {"problems", report.problems},
          {"whole", report.whole()}};
}

int tell_report(const capture::TakeReport& report, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", to_json(report).dump(2));
    return report.whole() ? kDone : kDoneWithLoss;
  }
  fmt::print("take {} ({}): {} frame sets, {} complete, {} incomplete\n", report.name, to_string(report.state),
             report.frame_sets, report.complete, report.incomplete);
  for (const auto& camera : report.cameras)
    if (camera.missing > 0 || camera.corrupt > 0)
      fmt::print("  {}: {} missing, {} corrupt\n", camera.name, camera.missing, camera.corrupt);
  for (const auto& gap : report.gaps)
    fmt::print("  {}: {} frames missing from trigger {} on\n", gap.camera, gap.frames, gap.first_trigger);
  for (const auto& problem : report.problems) fmt::print("  problem: {}\n", problem);
  if (report.state == capture::TakeState::recording)
    fmt::print("  it was never closed; count and close it with: rotunda take recover {}\n", report.name);
  return report.whole() ? kDone : kDoneWithLoss;
}

using Check = capture::TakeReport (*)(const fs::path&, const capture::Progress&, std::stop_token);

int check_take(const CommandLine& line, const std::string& name, const char* what, Check check, std::stop_token stop) {
  const auto folder = find_take(line, name);
  capture::TakeReport report;
  {
    Progress bar(what);
    report = check(
        folder, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, stop);
  }
  const int code = tell_report(report, line.json);
  for (const auto& camera : capture::moves_in_words(folder)) fmt::print(stderr, "warning: {}\n", camera);
  return code;
}

}  // namespace

void add_take_check_commands(CLI::App& take, CommandLine& line) {
  add_on_take(take, line, "verify", "reads every frame and checks it against its checksum",
              [&line](const std::string& name, std::stop_token stopping) {
                return check_take(line, name, "verifying", capture::verify_take, std::move(stopping));
              });
  add_on_take(take, line, "recover", "closes a take whose recording was cut off; recorded frames stay untouched",
              [&line](const std::string& name, std::stop_token stopping) {
                return check_take(line, name, "recovering", capture::recover_take, std::move(stopping));
              });
}

}  // namespace rotunda::rig
