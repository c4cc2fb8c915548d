#include "simulator/gige/fault_control.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace rotunda::simulator {
namespace {

using capture::RigClock;
using capture::Timestamp;
using nlohmann::json;

void apply(const FaultScript& script, GigeStudio& studio, Timestamp from) {
  if (script.seed) studio.seed_faults(*script.seed);
  for (const auto& entry : script.faults)
    for (const auto camera : entry.cameras) studio.add_fault(camera, entry.fault, from);
}

json json_of(const FaultCounts& fired) {
  json all = json::object();
  for (std::size_t kind = 0; kind < kFaultKinds; ++kind)
    all[std::string(to_string(static_cast<FaultKind>(kind)))] = fired.fired[kind];
  return all;
}

json json_of(const GigeStats& stats, const std::string& name) {
  json in_force = json::array();
  for (const auto kind : stats.in_force) in_force.push_back(to_string(kind));
  return {{"name", name},
          {"has_controller", stats.has_controller},
          {"is_acquiring", stats.is_acquiring},
          {"triggers", stats.triggers},
          {"ignored_triggers", stats.ignored_triggers},
          {"late_actions", stats.late_actions},
          {"frames_sent", stats.frames_sent},
          {"missing_pictures", stats.missing_pictures},
          {"packets_sent", stats.packets_sent},
          {"packets_lost", stats.packets_lost},
          {"packets_resent", stats.packets_resent},
          {"packets_unavailable", stats.packets_unavailable},
          {"resend_requests", stats.resend_requests},
          {"send_errors", stats.send_errors},
          {"denied", stats.denied},
          {"lost_controllers", stats.lost_controllers},
          {"in_force", in_force},
          {"faults", json_of(stats.faults)}};
}

json status_of(const GigeStudio& studio, const std::vector<std::string>& cameras) {
  FaultCounts fired;
  json all = json::array();
  const auto stats = studio.stats();
  for (std::size_t i = 0; i < stats.size(); ++i) {
    fired += stats[i].faults;
    all.push_back(json_of(stats[i], cameras[i]));
  }
  return {{"ok", true}, {"faults", json_of(fired)}, {"cameras", all}};
}

json help(const std::vector<std::string>& cameras) {
  json kinds = json::array();
  for (std::size_t kind = 0; kind < kFaultKinds; ++kind) kinds.push_back(to_string(static_cast<FaultKind>(kind)));
  return {{"ok", true},
          {"requests",
           {"status", "clear", "clear: " + cameras.front(), "seed: 7", cameras.front() + ": { silence: 2s }",
            "{ camera: all, at: trigger 40, for: 3 triggers, packet_loss: 5% }"}},
          {"faults", kinds},
          {"cameras", cameras}};
}

json answer(GigeStudio& studio, const std::vector<std::string>& cameras, const std::string& line) {
  const Timestamp now = RigClock::now();
  const auto request = parse_fault_request(line, cameras);
  switch (request.what) {
    case FaultRequest::What::status:
      return status_of(studio, cameras);
    case FaultRequest::What::help:
      return help(cameras);
    case FaultRequest::What::clear:
      for (const auto camera : request.cameras) studio.clear_faults(camera);
      return {{"ok", true}, {"cleared", request.cameras.size()}};
    case FaultRequest::What::add:
      break;
  }
  apply(request.script, studio, now);
  std::size_t added = 0;
  for (const auto& entry : request.script.faults) added += entry.cameras.size();
  return {{"ok", true}, {"added", added}};
}

}  // namespace

FaultControl::FaultControl(FaultControlOptions options, std::vector<std::string> cameras)
    : options_(std::move(options)), cameras_(std::move(cameras)) {
  if (!options_.script.empty()) script_ = load_fault_script(options_.script, cameras_);
}

void FaultControl::start(GigeStudio& studio) {
  apply(script_, studio, RigClock::now());
  if (options_.socket.empty()) return;
  socket_ = std::make_unique<ControlSocket>(options_.socket, [this, &studio](const std::string& line) {
    return answer_fault_request(studio, cameras_, line);
  });
}

void FaultControl::stop() {
  socket_.reset();
}

std::string answer_fault_request(GigeStudio& studio, const std::vector<std::string>& cameras, const std::string& line) {
  json reply;
  try {
    reply = answer(studio, cameras, line);
  } catch (const std::exception& error) {
    reply = {{"ok", false}, {"error", error.what()}};
  }
  return reply.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string fault_summary(const std::vector<GigeStats>& stats, const std::vector<std::string>& cameras) {
  std::string lines;
  for (std::size_t i = 0; i < stats.size(); ++i) {
    std::vector<std::string> fired;
    for (std::size_t kind = 0; kind < kFaultKinds; ++kind)
      if (const auto times = stats[i].faults.fired[kind]; times > 0)
        fired.push_back(fmt::format("{} {}", to_string(static_cast<FaultKind>(kind)), times));
    if (!fired.empty()) lines += fmt::format("{}{}: {}", lines.empty() ? "" : "\n", cameras[i], fmt::join(fired, ", "));
  }
  return lines.empty() ? "no fault fired" : lines;
}

}  // namespace rotunda::simulator
