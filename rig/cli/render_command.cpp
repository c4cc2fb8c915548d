// rotunda render: geometry videos and characters as pictures and films.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "playback/character_film.h"
#include "playback/display/headless.h"
#include "playback/render/film_strip.h"
#include "playback/render/film_writer.h"
#include "playback/render/frame_painter.h"
#include "playback/render/orbit_film.h"
#include "playback/viewpoint.h"
#include "recon/motion/character.h"
#include "recon/stage_clock.h"
#include "recon/video/geometry_video.h"
#include "rig/cli/clip_choice.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct RenderArguments {
  std::string clip, view, frames;
  std::vector<int> size;        // width, height
  std::vector<int> background;  // red, green, blue
  bool orbit = false;
  ViewDependent view_dependent;
  std::optional<std::size_t> frame;
  double turns = 1.0;
  int moments = 10;
  fs::path output, script;
};

std::optional<recon::Colour> background_of(const RenderArguments& arguments) {
  if (arguments.background.empty()) return std::nullopt;
  recon::Colour colour{};
  std::transform(arguments.background.begin(), arguments.background.end(), colour.begin(),
                 [](int value) { return static_cast<std::uint8_t>(value); });
  return colour;
}

// "calibration.yaml:cam03"; the file's own name may hold colons.
capture::CameraModel camera_from(const std::string& view) {
  const auto colon = view.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == view.size())
    throw InvalidInput("\"" + view + "\" names no camera; write CALIBRATION:CAMERA, such as calibration.yaml:cam03");
  const auto name = view.substr(colon + 1);
  std::string known;
  for (const auto& camera : capture::read_calibration(view.substr(0, colon))) {
    if (camera.name == name) return camera;
    known += (known.empty() ? "" : ", ") + camera.name;
  }
  throw InvalidInput(fmt::format("{} has no camera {}; it has {}", view.substr(0, colon), name, known));
}

int tell(const CommandLine& line, const recon::StageClock& clock, const fs::path& output, bool finished) {
  const auto costs = clock.costs();
  if (line.json) {
    json report{{"output", output.string()}, {"finished", finished}};
    if (!costs.empty())
      report.update({{"pictures", costs[0].count}, {"median_ms", costs[0].median_ms}, {"cpu_s", costs[0].cpu_s}});
    fmt::print("{}\n", report.dump(2));
  } else if (!costs.empty()) {
    fmt::print("{:<10} {:>6} {:>12} {:>12} {:>9}\n", "stage", "runs", "median ms", "CPU ms", "CPU s");
    for (const auto& cost : costs)
      fmt::print("{:<10} {:>6} {:>12.1f} {:>12.1f} {:>9.1f}\n", cost.stage, cost.count, cost.median_ms,
                 cost.median_cpu_ms, cost.cpu_s);
  }
  if (!finished) fmt::print(stderr, "interrupted; nothing half-made is left\n");
  return finished ? kDone : kDoneWithLoss;
}

std::unique_ptr<playback::FramePainter> painter_for(const CommandLine& line, const RenderArguments& arguments,
                                                    recon::GeometryVideoReader& video) {
  auto pictures = chosen_pictures(line, arguments.clip, arguments.view_dependent);
  return pictures ? playback::view_dependent_painter(video, std::move(pictures)) : playback::stored_painter(video);
}

int render_orbit(const CommandLine& line, const RenderArguments& arguments, recon::GeometryVideoReader& video,
                 std::stop_token stop) {
  playback::OrbitFilmOptions options;
  if (!arguments.size.empty()) {
    options.width = arguments.size[0];
    options.height = arguments.size[1];
  }
  std::tie(options.first_frame, options.last_frame) = chosen_frames(arguments.frames, arguments.frame, video.header());
  options.turns = arguments.turns;
  options.background = background_of(arguments);
  options.stop = stop;
  const auto painter = painter_for(line, arguments, video);
  playback::FilmOptions film_options{.width = options.width, .height = options.height, .fps = video.header().fps};
  if (options.background) film_options.background = *options.background;
  const auto film = playback::make_film_writer(arguments.output, film_options);
  Progress bar("rendering");
  recon::StageClock clock;
  recon::StageClock::Laps laps(clock, "render");
  options.progress = [&](int done, int all) {
    laps.lap();
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
  playback::render_orbit(playback::performer_path(video.header()), {painter.get()}, options, *film);
  return tell(line, clock, arguments.output, !stop.stop_requested());
}

cv::Mat draw(playback::FramePainter& painter, const playback::Viewpoint& viewpoint,
             const std::optional<recon::Colour>& background) {
  // Drawn twice as large and averaged: edges get their share of alpha.
  constexpr int kSupersampling = 2;
  auto larger = playback::magnified(viewpoint, kSupersampling);
  const playback::RenderTarget target(larger.width, larger.height);
  target.bind();
  playback::clear(background);
  painter.draw(larger);
  return playback::reduce(target.read_rgba(), kSupersampling);
}

playback::Viewpoint viewpoint_for(const RenderArguments& arguments, const recon::GeometryImage& image) {
  if (!arguments.view.empty()) return playback::viewpoint_of(camera_from(arguments.view));
  Eigen::AlignedBox3d box;
  for (const auto& position : image.positions) box.extend(position.cast<double>());
  const auto size = arguments.size.empty() ? std::vector<int>{1280, 720} : arguments.size;
  return playback::orbit_around(box).viewpoint(size[0], size[1]);
}

int render_view(const CommandLine& line, const RenderArguments& arguments, recon::GeometryVideoReader& video,
                std::stop_token stop) {
  if (!arguments.view.empty() && !arguments.size.empty())
    throw InvalidInput("--view draws through that camera at its own size; leave --size out");
  const auto [first, end] = chosen_frames(arguments.frames, arguments.frame, video.header());
  const auto viewpoint = viewpoint_for(arguments, video.read(first));
  const auto background = background_of(arguments);
  const bool one_picture = arguments.output.extension() == ".png";
  if (one_picture && end - first > 1)
    throw InvalidInput(
        fmt::format("{} holds one picture, {} frames are asked for; add --frame N, or name a folder or "
                    "film.mp4 with -o",
                    arguments.output.string(), end - first));
  const auto painter = painter_for(line, arguments, video);
  std::unique_ptr<playback::FilmWriter> film;
  if (!one_picture)
    film = playback::make_film_writer(
        arguments.output, {.width = viewpoint.width, .height = viewpoint.height, .fps = video.header().fps});
  recon::StageClock clock;
  Progress bar("rendering");
  for (int frame = first; frame < end && !stop.stop_requested(); ++frame) {
    clock.run("render", [&] {
      painter->show(frame);
      const auto picture = draw(*painter, viewpoint, background);
      if (film)
        film->write(picture);
      else
        capture::write_png(arguments.output, picture);
    });
    bar.update(static_cast<std::size_t>(frame) + 1 - static_cast<std::size_t>(first),
               static_cast<std::size_t>(end - first));
  }
  if (film && !stop.stop_requested()) film->finish();
  return tell(line, clock, arguments.output, !stop.stop_requested());
}

// A film, a folder of pictures, or a strip of moments in one picture.
std::unique_ptr<playback::FilmWriter> film_of(const fs::path& output, const playback::CharacterFilmOptions& options,
                                              int moments, double fps) {
  const auto background = options.background.value_or(playback::FilmOptions{}.background);
  if (output.extension() == ".png")
    return playback::make_film_strip(output, {.width = options.width,
                                              .height = options.height,
                                              .pictures = playback::picture_count(options.script, fps),
                                              .moments = moments,
                                              .background = background});
  return playback::make_film_writer(
      output, {.width = options.width, .height = options.height, .fps = fps, .background = background});
}

// A character performs what the script says; without one its first state, once round.
int render_performance(const CommandLine& line, const RenderArguments& arguments, std::stop_token stop) {
  if (!arguments.view.empty() || arguments.frame || !arguments.frames.empty())
    throw InvalidInput("a character is filmed with --script FILE or --orbit; leave --view, --frame and --frames out");
  const auto graph = recon::open_character(arguments.clip);
  playback::CharacterFilmOptions options;
  const auto output = arguments.output.empty() ? fs::path("character.mp4") : arguments.output;
  if (output.extension() == ".png") {
    options.width = playback::FilmStripOptions{}.width;
    options.height = playback::FilmStripOptions{}.height;
  }
  if (!arguments.size.empty()) {
    options.width = arguments.size[0];
    options.height = arguments.size[1];
  }
  if (!arguments.script.empty())
    options.script = playback::read_script(arguments.script, graph);
  else
    options.script.seconds = 3.0 * playback::first_cycle_seconds(graph);
  options.turns = arguments.orbit ? arguments.turns : 0.0;
  options.stop = stop;
  options.background = background_of(arguments);
  if (!options.background && !output.extension().empty()) options.background = playback::FilmOptions{}.background;
  const auto film = film_of(output, options, arguments.moments, graph.fps);
  Progress bar("rendering");
  recon::StageClock clock;
  recon::StageClock::Laps laps(clock, "render");
  options.progress = [&](int done, int all) {
    laps.lap();
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
  const playback::HeadlessDisplay display;
  playback::render_character(arguments.clip, graph, options, *film);
  return tell(line, clock, output, !stop.stop_requested());
}

int render(const CommandLine& line, RenderArguments arguments, std::stop_token stop) {
  if (recon::is_character(arguments.clip)) return render_performance(line, arguments, std::move(stop));
  if (!arguments.script.empty())
    throw InvalidInput(
        fmt::format("{} is no character: scripts are for folders that rotunda character build made", arguments.clip));
  if (arguments.orbit && (!arguments.view.empty() || arguments.frame))
    throw InvalidInput("--orbit goes round by itself; leave --view and --frame out");
  recon::GeometryVideoReader video(find_video(line, arguments.clip));
  if (arguments.output.empty()) arguments.output = arguments.orbit ? "orbit.mp4" : "view.png";
  const playback::HeadlessDisplay display;
  return arguments.orbit ? render_orbit(line, arguments, video, std::move(stop))
                         : render_view(line, arguments, video, std::move(stop));
}

}  // namespace

void add_render_command(CommandLine& line) {
  auto arguments = std::make_shared<RenderArguments>();
  auto* app =
      line.app.add_subcommand("render", "draws a geometry video, or a character's performance, from any viewpoint");
  app->add_option("clip", arguments->clip, "a take, by name or path, a geometry video's file, or a character's folder")
      ->required();
  app->add_option("--script", arguments->script, "of a character: what it does when (YAML)");
  auto* view = app->add_option("--view", arguments->view, "CALIBRATION:CAMERA: exactly through that camera");
  app->add_flag("--orbit", arguments->orbit, "a film that goes round the performer")->excludes(view);
  app->add_option("--turns", arguments->turns, "of the orbit")->capture_default_str();
  auto* frames = app->add_option("--frames", arguments->frames, "A:B, half-open, counted from 0");
  app->add_option("--frame", arguments->frame, "this frame alone")->excludes(frames);
  app->add_option("--size", arguments->size, "WIDTHxHEIGHT (1280x720)")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(16, 16384));
  add_view_dependent(*app, arguments->view_dependent);
  app->add_option("--background", arguments->background, "R,G,B; else PNG pictures have straight alpha")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(0, 255));
  app->add_option("--moments", arguments->moments, "of a character's performance, side by side in one FILE.png")
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  app->add_option("-o,--output", arguments->output, "FILE.png, FILE.mp4 or a folder of pictures (orbit.mp4, view.png)");
  app->footer(
      "Examples:\n  rotunda render demo --orbit -o orbit.mp4\n"
      "  rotunda render demo --view calibration.yaml:cam03 --frame 12 -o view.png\n"
      "  rotunda render demo --orbit --view-dependent -o orbit.mp4\n"
      "  rotunda render alex --script performance.yaml -o performance.mp4\n"
      "  rotunda render alex --script performance.yaml --moments 12 -o strip.png\n"
      "A script: - {at: 1.0, state: walk}, - {at: 3.5, turn_deg: 40}, - {at: 5.0, speed: 1.6}, a line each.");
  app->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return render(line, *arguments, std::move(stop)); };
  });
}

}  // namespace rotunda::rig
