// rotunda-sim render: the studio as files, or into the frame cache.
#include <fmt/format.h>

#include "capture/calibration_file.h"
#include "config/exit_code.h"
#include "simulator/cli/command_line.h"
#include "simulator/picture_set.h"

namespace rotunda::simulator {
namespace {

struct RenderOptions {
  LayoutArguments layout;
  PerformanceArguments performance;
  StudioArguments studio;
  CacheArguments cache;
  std::string calibration, rig, output;
  int frames = 1;
  bool cache_only = false;
};

ServedStudio studio_of(const RenderOptions& options) {
  auto studio = options.rig.empty() ? studio_of_layout(layout_of(options.layout, options.performance))
                                    : studio_of_rig(options.rig);
  if (!options.calibration.empty()) studio.cameras = capture::read_calibration(options.calibration);
  apply(options.performance, studio.performance);
  apply(options.studio, studio);
  return studio;
}

int render_into_cache(const ServedStudio& studio, const RenderOptions& options, const std::stop_token& stop) {
  const auto act = act_options(studio, options.cache, stop);
  return prepare_act(act) ? kDone : kDoneWithLoss;
}

int render_files(const ServedStudio& studio, const RenderOptions& options, const std::stop_token& stop) {
  const auto performance = make_performance(studio.performance);
  SceneRenderer renderer(*performance, studio.cameras, studio.sensor(), studio.backdrop);
  const auto progress = progress_bar("frames written");
  const int written = write_picture_set(options.output, renderer, options.frames, stop,
                                        [&](int done) { progress(done, options.frames); });
  return written == options.frames ? kDone : kDoneWithLoss;
}

}  // namespace

void add_render_command(CommandLine& line) {
  auto* command = line.app.add_subcommand("render", "write pictures, empty studio, calibration and truth as files");
  command->footer(
      "Examples:\n  rotunda-sim render --cameras 16 --size 1280x960 --aspect 16/15 --frames 4 -o studio16\n"
      "  rotunda-sim render --cache-only --rig config/simulated-studio.yaml --act dance");
  const auto options = std::make_shared<RenderOptions>();
  add_performance_options(*command, options->performance);
  add_studio_options(*command, options->studio);
  auto* calibration = command->add_option("--calibration", options->calibration, "the cameras of this file instead");
  auto* rig = command->add_option("--rig", options->rig, "the cameras of this rig file instead")->excludes(calibration);
  add_layout_options(*command, options->layout, rig, calibration);
  command->add_option("--frames", options->frames, "frames of 40 ms (1)")->check(CLI::PositiveNumber);
  auto* output = command->add_option("-o,--output", options->output, "folder to write");
  auto* ahead = command->add_flag("--cache-only", options->cache_only,
                                  "render the whole act into the frame cache, so that serving it starts at once");
  add_cache_options(*command, options->cache);
  ahead->excludes(output)->excludes(command->get_option("--no-cache"))->excludes(calibration);
  command->callback([&line, options] {
    if (options->output.empty() && !options->cache_only) throw CLI::RequiredError("--output");
    line.run = [options](const std::stop_token& stop) -> int {
      const auto studio = studio_of(*options);
      return options->cache_only ? render_into_cache(studio, *options, stop) : render_files(studio, *options, stop);
    };
  });
}

}  // namespace rotunda::simulator
