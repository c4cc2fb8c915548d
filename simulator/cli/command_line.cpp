#include "simulator/cli/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "capture/base/interrupt.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "simulator/people/act.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {
namespace {

// Nothing, with a warning, if nobody named a folder and the usual one cannot be made.
std::optional<FrameCache::Options> cache_options(const CacheArguments& arguments) {
  if (arguments.none) return std::nullopt;
  FrameCache::Options options;
  if (arguments.folder) options.folder = *arguments.folder;
  options.most_bytes = static_cast<std::uint64_t>(1e9 * arguments.gigabytes);
  std::error_code failed;
  std::filesystem::create_directories(options.folder, failed);
  if (!failed || arguments.folder) return options;
  spdlog::warn("frames are not kept: {}: {}", options.folder.string(), failed.message());
  return std::nullopt;
}

}  // namespace

void add_performance_options(CLI::App& command, PerformanceArguments& arguments) {
  command.add_option("--person", arguments.person,
                     fmt::format("who: {}, or FILE.glb", fmt::join(person_names(), ", ")));
  command.add_option("--act", arguments.act,
                     fmt::format("does what: {}, or a clip of FILE.glb", fmt::join(act_names(), ", ")));
  command.add_option("--motion", arguments.motion, "FILE.bvh that moves the person, instead of an act");
  command.add_flag("--travel", arguments.travel, "through the volume instead of on the spot");
  command.add_option("--seed", arguments.seed, "of small variations in motion and of the sensors' noise (1)");
}

void apply(const PerformanceArguments& arguments, PerformanceOptions& options) {
  if (arguments.person) options.person = *arguments.person;
  if (arguments.act) options.act = *arguments.act;
  if (arguments.motion) options.motion = *arguments.motion;
  if (arguments.seed) options.seed = *arguments.seed;
  if (arguments.travel) options.travel = true;
}

void add_cache_options(CLI::App& command, CacheArguments& arguments) {
  auto* folder = command.add_option("--cache", arguments.folder,
                                    "folder of the frames rendered ahead (" + FrameCache::default_folder().string() +
                                        "); the entries unused for longest make room");
  auto* none = command.add_flag("--no-cache", arguments.none, "render anew and hold all frames in memory");
  command.add_option("--cache-size", arguments.gigabytes, "gigabytes the cache may take (20)")
      ->check(CLI::PositiveNumber);
  folder->excludes(none);
}

void add_layout_options(CLI::App& command, LayoutArguments& arguments, CLI::Option* file, CLI::Option* other_file) {
  const auto add = [&](CLI::Option* option) {
    for (auto* instead : {file, other_file})
      if (instead) option->excludes(instead);
    return option;
  };
  add(command.add_option("--cameras", arguments.layout.cameras,
                         "2 to 64; four in five on a ring, the rest from above (10)"))
      ->check(CLI::Range(2, 64));
  add(command.add_option("--radius", arguments.radius, "of the ring in metres (3.6; 6 for acts that travel)"))
      ->check(CLI::Range(1.0, 50.0));
  auto* subject = add(command.add_option("--subject-height", arguments.subject_height,
                                         "metres amid the stage that fill the picture's height (2.3)"));
  subject->check(CLI::Range(0.05, 50.0));
  add(command.add_flag("--whole-volume", arguments.whole_volume,
                       "lenses that hold the whole stage of 3 x 2 x 2 m (so for acts that travel)"))
      ->excludes(subject);
  add(command.add_option("--size", arguments.size, "WIDTHxHEIGHT in pixels (720x576)"))
      ->delimiter('x')
      ->check(CLI::Range(16, 16384));
  add(command.add_option("--aspect", arguments.aspect, "fy / fx, as 16/15 or 1.0667 (1)"))
      ->delimiter('/')
      ->expected(1, 2)
      ->check(CLI::PositiveNumber);
  add(command.add_option("--skew", arguments.layout.skew_px, "K[0][1] in pixels (0)"));
  add(command.add_option("--k1", arguments.layout.k1, "radial distortion (0)"));
  add(command.add_option("--k2", arguments.layout.k2, "radial distortion (0)"));
}

bool travels(const PerformanceOptions& performance) {
  return !performance.motion && (performance.travel || performance.act == "board");
}

LayoutOptions layout_of(const LayoutArguments& arguments, const PerformanceArguments& performance) {
  PerformanceOptions wanted;
  apply(performance, wanted);
  LayoutOptions layout = arguments.layout;
  if (arguments.whole_volume || (travels(wanted) && !arguments.subject_height)) layout = travelling_layout(layout);
  if (arguments.radius) layout.radius = *arguments.radius;
  if (arguments.subject_height) layout.subject_height = *arguments.subject_height;
  std::tie(layout.width, layout.height) = arguments.size;
  layout.aspect = arguments.aspect.front() / (arguments.aspect.size() > 1 ? arguments.aspect.back() : 1.0);
  return layout;
}

void add_studio_options(CLI::App& command, StudioArguments& arguments) {
  command.add_option("--screen", arguments.screen, "paint of the room: blue or green (the rig file's, else blue)")
      ->check(CLI::IsMember({"blue", "green"}));
  command
      .add_option("--wear", arguments.wear,
                  "of the painted room: seams, roller marks, scuffs, tape; 0 none, 2 many (1)")
      ->check(CLI::Range(0.0, 4.0));
  command.add_option("--unevenness", arguments.unevenness, "of the light on it, brightest to darkest (2)")
      ->check(CLI::Range(1.0, 10.0));
  command.add_option("--lateral-colour", arguments.lateral_colour_px, "of the lenses, pixels in the corner (0.25)")
      ->check(CLI::Range(0.0, 5.0));
}

void apply(const StudioArguments& arguments, ServedStudio& studio) {
  if (!arguments.screen.empty())
    studio.backdrop.paint = arguments.screen == "green" ? ScreenPaint::green : ScreenPaint::blue;
  if (arguments.wear) studio.backdrop.wear = *arguments.wear;
  if (arguments.unevenness) studio.backdrop.unevenness = *arguments.unevenness;
  if (arguments.lateral_colour_px) studio.lateral_colour_px = *arguments.lateral_colour_px;
}

AheadProgress progress_bar(const std::string& what) {
  return [what, bar = std::shared_ptr<Progress>()](int done, int all) mutable {
    if (!bar) bar = std::make_shared<Progress>(what);  // its clock starts with the work
    bar->update(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
}

ActOptions act_options(const ServedStudio& studio, const CacheArguments& cache, const std::stop_token& stop) {
  return {.performance = studio.performance,
          .cameras = studio.cameras,
          .sensor = studio.sensor(),
          .backdrop = studio.backdrop,
          .format = studio.devices.front().format,
          .cache = cache_options(cache),
          .progress = progress_bar("rendering ahead"),
          .stop = stop};
}

int run_rotunda_sim(int argc, const char* const* argv) {
  const capture::Interrupt interrupt;
  CommandLine line;
  line.app.set_version_flag("--version", "rotunda-sim 0.1.0");
  line.app.require_subcommand(0, 1);
  add_serve_command(line);
  add_render_command(line);
  add_layout_command(line);
  add_gallery_command(line);
  add_fault_command(line);
  try {
    line.app.parse(argc, argv);
    return line.run(interrupt.token());
  } catch (const CLI::ParseError& error) {
    return line.app.exit(error) == 0 ? kDone : kUsage;
  } catch (...) {
    return report_current_exception("rotunda-sim");
  }
}

}  // namespace rotunda::simulator
