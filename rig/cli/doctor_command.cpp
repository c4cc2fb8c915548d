// rotunda doctor: what of this machine, or of the rig, would cost frames, and the cure.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "playback/render/gl_objects.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"
#include "rig/machine_facts.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

RendererFacts look_at_renderer() {
  try {
    const playback::HeadlessDisplay headless;
    const playback::RenderTarget target(64, 64);
    return {.name = reinterpret_cast<const char*>(glGetString(GL_RENDERER)), .problem = ""};
  } catch (const DeviceError& error) {
    return {.name = "", .problem = error.what()};
  }
}

// The running daemon's, if one answers.
std::optional<RigStatus> daemons_status(const CommandLine& line) {
  const auto socket = daemon_socket(line.daemon);
  if (!fs::exists(socket)) return std::nullopt;
  try {
    return RigClient(socket).status();
  } catch (const DeviceError&) {
    return std::nullopt;
  }
}

// A disk that takes a recording now is not tried as well.
bool records(const std::optional<RigStatus>& status) {
  return status && (status->state == "recording" || status->state == "stopping");
}

json to_json(const std::vector<Finding>& findings) {
  json checks = json::array();
  for (const auto& finding : findings)
    checks.push_back({{"what", finding.what},
                      {"verdict", to_string(finding.verdict)},
                      {"measured", finding.measured},
                      {"cure", finding.cure}});
  return checks;
}

int examine(const CommandLine& line, const fs::path& rig_file) {
  std::optional<config::RigConfig> rig;
  if (!rig_file.empty()) rig = config::load_rig(rig_file);
  const auto status = daemons_status(line);
  const bool storage_of_rig = rig && line.takes.empty() && !status;
  auto facts = machine_facts(storage_of_rig ? rig->storage.takes : takes_folder(line), rig);
  facts.status = status;
  if (facts.disk.writable && !records(status)) facts.disk.bytes_per_second = measure_disk(facts.disk.folder, {});
  facts.renderer = look_at_renderer();
  const auto findings = preflight(facts);
  const auto reasons = why_not_record(findings);
  if (line.json) {
    fmt::print("{}\n", json{{"checks", to_json(findings)}, {"cannot_record", reasons}}.dump(2));
  } else {
    for (const auto& finding : findings) fmt::print("{}", lines_of(finding));
    for (const auto& reason : reasons) fmt::print("\ncannot record: {}\n", reason);
  }
  const bool look =
      std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.verdict >= Verdict::look; });
  return look ? kDoneWithLoss : kDone;
}

}  // namespace

void add_doctor_command(CommandLine& line) {
  auto* doctor = line.app.add_subcommand(
      "doctor", "checks this machine and the rig: cameras, disk, links, MTU, socket buffers, clocks, calibration");
  auto rig = std::make_shared<fs::path>();
  doctor->add_option("--rig", *rig, "a rig file: the checks then know what it needs");
  doctor->footer(
      "good: as it should be. note: costs something in some uses. LOOK: costs frames or takes that are of no use.\n"
      "STOP: nothing can be recorded. The cure stands below. With a running daemon its cameras are looked at too.\n"
      "It writes 200 MB to the takes' disk and deletes them, unless a take is recorded there now.\n"
      "Example:\n  rotunda doctor --rig studio.yaml\nExit code 1 if something should be looked at.");
  doctor->callback([&line, rig] { line.run = [&line, rig](std::stop_token) { return examine(line, *rig); }; });
}

}  // namespace rotunda::rig
