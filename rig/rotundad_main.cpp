// The daemon: cameras, triggers, takes, and the control API on a Unix socket.
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "capture/base/interrupt.h"
#include "config/exit_code.h"
#include "rig/daemon/rig_daemon.h"
#include "rig/daemon/rig_service.h"
#include "rig/machine_facts.h"

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct Options {
  fs::path rig, socket, takes;
  bool check = false, surfaces = true;
};

int serve(const rotunda::config::RigConfig& rig, const Options& options, std::stop_token stop) {
  const auto socket =
      options.socket.empty() && rig.api_socket ? *rig.api_socket : rotunda::rig::daemon_socket(options.socket);
  const rotunda::rig::SocketLock lock(socket);
  rotunda::rig::RigDaemon daemon(rig, options.surfaces);
  const rotunda::rig::RigServer server(daemon, lock);
  if (!daemon.wait_until_tried(stop)) return rotunda::kDone;
  const auto status = daemon.status();
  const auto streaming = std::count_if(status.cameras.begin(), status.cameras.end(),
                                       [](const auto& camera) { return camera.state == "streaming"; });
  spdlog::info("ready: {} of {} cameras, trigger {}, API on {}", streaming, status.cameras.size(), status.trigger,
               socket.string());
  while (!stop.stop_requested()) std::this_thread::sleep_for(50ms);
  spdlog::info("stopping");
  return rotunda::kDone;
}

// Without touching a camera. What it finds does not make the rig file a bad one.
void tell_preflight(const rotunda::config::RigConfig& rig) {
  auto facts = rotunda::rig::machine_facts(rig.storage.takes, rig);
  facts.disk.bytes_per_second = rotunda::rig::measure_disk(facts.disk.folder, {});
  for (const auto& finding : rotunda::rig::preflight(facts))
    std::fputs(rotunda::rig::lines_of(finding).c_str(), stdout);
}

int run(const Options& options) {
  const rotunda::capture::Interrupt interrupt;
  try {
    auto rig = rotunda::config::load_rig(options.rig);
    if (!options.takes.empty()) rig.storage.takes = fs::absolute(options.takes);
    if (options.check) {
      std::printf("%s: good, %zu cameras\n", options.rig.c_str(), rig.cameras.size());
      tell_preflight(rig);
      return rotunda::kDone;
    }
    return serve(rig, options, interrupt.token());
  } catch (...) {
    return rotunda::report_current_exception("rotundad");
  }
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("rotundad"));
  spdlog::set_pattern("%H:%M:%S.%e %l %v");
  CLI::App app{"The capture daemon: syncs and triggers the rig's cameras and records takes", "rotundad"};
  Options options;
  app.add_option("--rig", options.rig, "the rig file")->required();
  app.add_flag("--check", options.check, "only check the rig file, and this machine for it");
  app.add_option("--takes", options.takes, "record here instead of the rig file's storage.takes");
  app.add_option("--socket", options.socket, "serve the control API here (else ROTUNDA_SOCKET, the runtime folder)");
  app.add_flag("--surfaces,!--no-surfaces", options.surfaces,
               "make surfaces of what the cameras see while they run (it does unless told not to)");
  app.footer("Example:\n  rotundad --rig config/simulated-studio.yaml");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? rotunda::kDone : rotunda::kUsage;
  }
  return run(options);
}
