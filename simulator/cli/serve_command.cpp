// rotunda-sim: serves cameras until it is told to stop; --scan and --list answer and end.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <condition_variable>
#include <fstream>
#include <mutex>
#include <system_error>

#include "config/exit_code.h"
#include "simulator/cli/command_line.h"
#include "simulator/cli/fault_command.h"
#include "simulator/cli/scan_command.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/people/act.h"
#include "simulator/people/person.h"
#include "simulator/studio/exposure_log.h"
#include "simulator/studio/re_exposure.h"

namespace rotunda::simulator {
namespace {

struct ServeOptions {
  PerformanceArguments performance;
  StudioArguments studio;
  CacheArguments cache;
  ScanArguments scan;
  FaultControlOptions faults;
  std::optional<double> exposure_us;
  LayoutArguments layout;
  std::optional<std::uint64_t> clock_seed;
  std::optional<std::uint16_t> trigger_box_port;
  std::string rig, truth, ready_file, clocks, pixel_format = "BayerRG8";
  bool list = false;
};

capture::PixelFormat format_of(const ServeOptions& options) {
  const auto format = capture::pixel_format_from(options.pixel_format);
  if (!format) throw CLI::ValidationError("--pixel-format", "cameras send Mono8, BayerRG8, RGB8, ...");
  return *format;
}

// The rig's cameras stand where its calibration says, whoever performs.
void tell_narrow_cameras(const ServedStudio& studio, const std::string& rig) {
  const auto narrow = narrow_cameras(studio.cameras);
  if (narrow.empty()) return;
  spdlog::warn(
      "{} goes through the whole stage; {} of {} do not have all of it in their pictures: {}. Where cameras stand is "
      "for "
      "the calibration of {} to say; `rotunda-sim layout --whole-volume -o FILE` writes one that holds the stage",
      studio.performance.person, narrow.size(), studio.cameras.size(), fmt::join(narrow, ", "), rig);
}

ServedStudio studio_of(const ServeOptions& options) {
  auto studio = options.rig.empty()
                    ? studio_of_layout(layout_of(options.layout, options.performance), format_of(options))
                    : studio_of_rig(options.rig);
  apply(options.performance, studio.performance);
  apply(options.studio, studio);
  if (options.exposure_us)
    for (auto& device : studio.devices) device.exposure_us = *options.exposure_us;
  if (!options.clocks.empty()) studio.has_realistic_clocks = options.clocks == "realistic";
  if (studio.has_realistic_clocks) use_realistic_clocks(studio, options.clock_seed.value_or(studio.performance.seed));
  if (!options.faults.script.empty()) studio.faults = options.faults.script;
  if (!options.rig.empty() && travels(studio.performance)) tell_narrow_cameras(studio, options.rig);
  return studio;
}

// What clients write on top of what the pictures were rendered with.
ReExpose re_exposure_of(const ServedStudio& studio, const std::unique_ptr<ActPlayer>& player) {
  auto cameras = std::make_shared<std::vector<ReExposure>>();
  for (std::size_t i = 0; i < studio.devices.size(); ++i)
    cameras->emplace_back(studio.sensor(), i, studio.devices[i].format, studio.devices[i].width);
  return [cameras, &player](std::size_t camera, capture::Timestamp at, const ImageSettings& written,
                            std::span<const std::uint8_t> picture) {
    const auto frame = static_cast<std::uint64_t>(act_frame_at(at, player->frames()));
    return (*cameras)[camera](picture, frame, exposure_settings(written));
  };
}

void tell_ready(const ServedStudio& studio, const std::string& ready_file) {
  const auto& devices = studio.devices;
  fmt::print("{} cameras ready on {} … {}\n", devices.size(), devices.front().address, devices.back().address);
  std::fflush(stdout);
  if (ready_file.empty()) return;
  std::ofstream file(ready_file + ".part");
  for (const auto& device : devices) file << device.name << ' ' << device.address << '\n';
  file.close();
  if (!file) throw std::system_error(errno, std::generic_category(), "cannot write " + ready_file);
  std::filesystem::rename(ready_file + ".part", ready_file);
}

void wait_for(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any asked;
  std::unique_lock lock(mutex);
  asked.wait(lock, stop, [] { return false; });
}

// What could not be shown as it should have been.
void tell_losses(const PlayerCounts& counts, const std::optional<ExposureLog>& log) {
  if (counts.late > 0) spdlog::warn("{} pictures came late from disk", counts.late);
  if (counts.damaged > 0) spdlog::warn("{} pictures of the frame cache were damaged, and not shown", counts.damaged);
  if (log && log->lost() > 0) spdlog::warn("{} exposures are missing from exposures.jsonl", log->lost());
}

int serve(const ServeOptions& options, const std::stop_token& stop) {
  const auto served = studio_of(options);
  const auto names = names_of(served.cameras);
  const FaultControlOptions fault_options{served.faults, options.faults.socket};
  FaultControl faults(fault_options, names);
  std::unique_ptr<ActPlayer> player;
  std::optional<ExposureLog> log;
  const auto on_exposure = [&](const Exposure& exposure) {
    log->add(exposure, act_frame_at(exposure.start, player->frames()));
  };
  // First of all, so that an address which is taken is told before minutes of rendering.
  GigeStudio studio(served.devices,
                    [&](std::size_t camera, capture::Timestamp at) { return player->picture_at(camera, at); },
                    {.on_exposure = options.truth.empty() ? OnExposure{} : on_exposure,
                     .re_expose = re_exposure_of(served, player),
                     .trigger_box_port = options.trigger_box_port});
  auto act = act_options(served, options.cache, stop);
  if (!options.truth.empty()) act.truth = options.truth;
  player = prepare_act(act);
  if (!player) return kDone;
  if (act.truth) log.emplace(*act.truth / "exposures.jsonl", names);
  studio.start();
  faults.start(studio);
  if (options.trigger_box_port)
    spdlog::info("listening for the trigger box's edges of Line0 on 127.0.0.1:{}", studio.trigger_box_port());
  tell_ready(served, options.ready_file);
  wait_for(stop);
  faults.stop();
  studio.stop();
  tell_faults(fault_options, studio.stats(), faults.cameras());
  tell_losses(player->counts(), log);
  if (!options.ready_file.empty()) std::filesystem::remove(options.ready_file);
  return kDone;
}

int list() {
  fmt::print("people:\n");
  for (const auto& name : person_names()) fmt::print("  {}\n", name);
  fmt::print("acts:\n");
  for (const auto& name : act_names()) fmt::print("  {}\n", name);
  return kDone;
}

}  // namespace

void add_serve_command(CommandLine& line) {
  line.app.footer(
      "Serves until Ctrl-C.\nExamples:\n  rotunda-sim --rig config/simulated-studio.yaml --act dance --truth truth\n"
      "  rotunda-sim --scan alex --triangles 294000 --flaws noise,holes -o scan.ply");
  const auto options = std::make_shared<ServeOptions>();
  auto* rig = line.app.add_option("--rig", options->rig, "serve the cameras of this rig file");
  add_layout_options(line.app, options->layout, rig);
  line.app.add_option("--pixel-format", options->pixel_format, "Mono8, BayerRG8, RGB8, ... (BayerRG8)")->excludes(rig);
  add_performance_options(line.app, options->performance);
  add_studio_options(line.app, options->studio);
  line.app
      .add_option("--exposure", options->exposure_us, "microseconds, of all cameras (as the rig file has it, or 5000)")
      ->check(CLI::PositiveNumber);
  line.app
      .add_option("--clocks", options->clocks,
                  "ideal: without error; realistic: crystals that drift, PTP that wanders (as the rig file has it, or "
                  "ideal)")
      ->check(CLI::IsMember({"ideal", "realistic"}));
  line.app.add_option("--clock-seed", options->clock_seed, "of the realistic clocks' errors (as --seed)");
  line.app.add_option("--trigger-box-port", options->trigger_box_port,
                      "UDP port of 127.0.0.1 for edges of Line0; 0: any (not listened for)");
  line.app.add_option("--truth", options->truth, "write what is true of each act frame and exposure into this folder");
  line.app.add_option("--ready-file", options->ready_file, "write this file once the cameras answer; gone at the end");
  add_fault_options(line.app, options->faults);
  add_cache_options(line.app, options->cache);
  add_scan_options(line.app, options->scan);
  line.app.add_flag("--list", options->list, "name people and acts");
  line.app.final_callback([&line, options] {
    if (line.run) return;  // a subcommand's
    line.run = [options](const std::stop_token& stop) -> int {
      if (options->list) return list();
      if (!options->scan.person.empty()) return write_scan(options->scan, options->performance);
      return serve(*options, stop);
    };
  });
}

}  // namespace rotunda::simulator
