// rotunda render, play, show: geometry videos as pictures, films, and in a window.
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
#include "playback/character_window.h"
#include "playback/contact_sheet.h"
#include "playback/display/headless.h"
#include "playback/player.h"
#include "playback/render/film_writer.h"
#include "playback/render/frame_painter.h"
#include "playback/render/orbit_film.h"
#include "playback/viewpoint.h"
#include "recon/live_take.h"
#include "recon/motion/character.h"
#include "recon/stage_clock.h"
#include "recon/take_studio.h"
#include "recon/video/geometry_video.h"
#include "rig/cli/character_report.h"
#include "rig/cli/clip_choice.h"
#include "rig/cli/command_line.h"
#include "rig/cli/live_view.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct RenderArguments {
  std::string clip, view, frames;
  std::vector<int> size;        // width, height
  std::vector<int> background;  // red, green, blue
  bool orbit = false, view_dependent = false;
  std::optional<fs::path> calibration;
  std::optional<std::size_t> frame;
  double turns = 1.0;
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
  if (!arguments.view_dependent) return playback::stored_painter(video);
  if (fs::is_regular_file(arguments.clip))
    throw InvalidInput(arguments.clip +
                       " is a geometry video alone; --view-dependent draws with the pictures of its "
                       "take: name the take instead");
  return playback::view_dependent_painter(video, find_take(line, arguments.clip), arguments.calibration);
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
  playback::render_orbit(video, *painter, options, *film);
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

// A character performs what the script says; without one its first state, once round.
int render_performance(const CommandLine& line, const RenderArguments& arguments, std::stop_token stop) {
  if (!arguments.view.empty() || arguments.frame || !arguments.frames.empty())
    throw InvalidInput("a character is filmed with --script FILE or --orbit; leave --view, --frame and --frames out");
  const auto graph = recon::open_character(arguments.clip);
  playback::CharacterFilmOptions options;
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
  const auto output = arguments.output.empty() ? fs::path("character.mp4") : arguments.output;
  options.background = background_of(arguments);
  if (!options.background && output.extension() == ".mp4") options.background = playback::FilmOptions{}.background;
  const auto film = playback::make_film_writer(output, {.width = options.width,
                                                        .height = options.height,
                                                        .fps = graph.fps,
                                                        .background = options.background.value_or(recon::Colour{})});
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
  if (arguments.calibration && !arguments.view_dependent)
    throw InvalidInput("--calibration says where the take's cameras stand; it goes with --view-dependent");
  recon::GeometryVideoReader video(find_video(line, arguments.clip));
  if (arguments.output.empty()) arguments.output = arguments.orbit ? "orbit.mp4" : "view.png";
  const playback::HeadlessDisplay display;
  return arguments.orbit ? render_orbit(line, arguments, video, std::move(stop))
                         : render_view(line, arguments, video, std::move(stop));
}

// A take that is not reconstructed yet is shown as the daemon left it: at live quality.
std::optional<fs::path> only_live_surfaces(const CommandLine& line, const std::string& clip) {
  if (fs::is_regular_file(clip) || recon::is_character(clip)) return std::nullopt;
  const auto take = find_take(line, clip);
  const auto live = recon::live_take_file(take);
  return fs::exists(live) && !fs::exists(recon::geometry_video_of(take)) ? std::optional(live) : std::nullopt;
}

int play_character(const CommandLine& line, const fs::path& character, const playback::PlayOptions& options) {
  const auto report = playback::play_character(character, recon::open_character(character), options);
  if (line.json)
    fmt::print(
        "{}\n",
        json{{"pictures", report.pictures}, {"seconds", report.seconds}, {"load_s", report.load_seconds}}.dump(2));
  return kDone;
}

int play(const CommandLine& line, const std::string& clip, playback::PlayOptions options, std::stop_token stop) {
  if (recon::is_character(clip)) {
    options.stop = std::move(stop);
    return play_character(line, clip, options);
  }
  recon::GeometryVideoReader video(find_video(line, clip));
  options.stop = std::move(stop);
  const auto report = playback::play(video, options);
  if (line.json)
    fmt::print("{}\n", json{{"pictures", report.pictures},
                            {"frames", report.frames},
                            {"late", report.late},
                            {"seconds", report.seconds}}
                           .dump(2));
  return kDone;
}

json header_report(const recon::GeometryVideoHeader& header) {
  json failed = json::array();
  for (int i = 0; i < header.frame_count(); ++i)
    if (header.statuses[static_cast<std::size_t>(i)].interpolated)
      failed.push_back(
          {{"frame", header.first_frame + i}, {"reason", header.statuses[static_cast<std::size_t>(i)].reason}});
  return {{"frames", header.frame_count()}, {"first_frame", header.first_frame},   {"fps", header.fps},
          {"level", header.level},          {"colour_level", header.colour_level}, {"interpolated", failed}};
}

int show(const CommandLine& line, const std::string& clip, const fs::path& picture, std::size_t frame) {
  if (recon::is_character(clip)) return show_character(line, {clip, picture, {}});
  if (!picture.empty() && !fs::is_regular_file(clip)) {
    capture::write_png(picture, playback::contact_sheet(find_take(line, clip), {.frame = frame}));
    if (!line.json) fmt::print("{}\n", picture.string());
    return kDone;
  }
  recon::GeometryVideoReader video(find_video(line, clip));
  if (!picture.empty()) capture::write_png(picture, playback::clip_sheet(video));
  const auto report = header_report(video.header());
  if (line.json)
    fmt::print("{}\n", report.dump(2));
  else
    fmt::print("{} frames from {} on at {} Hz, level {}, {} interpolated\n", video.frame_count(),
               video.header().first_frame, video.header().fps, video.header().level, report["interpolated"].size());
  return kDone;
}

void add_render(CommandLine& line) {
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
  app->add_flag("--view-dependent", arguments->view_dependent,
                "of a take: in the colours of its own pictures, mixed anew for every viewpoint");
  app->add_option("--calibration", arguments->calibration,
                  "of --view-dependent: what the take was reconstructed with, if not its own");
  app->add_option("--background", arguments->background, "R,G,B; else PNG pictures have straight alpha")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(0, 255));
  app->add_option("-o,--output", arguments->output, "FILE.png, FILE.mp4 or a folder of pictures (orbit.mp4, view.png)");
  app->footer(
      "Examples:\n  rotunda render demo --orbit -o orbit.mp4\n"
      "  rotunda render demo --view calibration.yaml:cam03 --frame 12 -o view.png\n"
      "  rotunda render demo --orbit --view-dependent -o orbit.mp4
"
      "  rotunda render alex --script performance.yaml -o performance.mp4
"
      "A script: - {at: 1.0, state: walk}, - {at: 3.5, turn_deg: 40}, - {at: 5.0, speed: 1.6}, a line each.");
  app->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return render(line, *arguments, std::move(stop)); };
  });
}

void add_play(CommandLine& line) {
  auto clip = std::make_shared<std::string>();
  auto options = std::make_shared<playback::PlayOptions>();
  auto live = std::make_shared<LiveViewRequest>();
  auto* app = line.app.add_subcommand(
      "play", "plays a take's geometry video or the rig live, or steers a character, in a window");
  auto* what = app->add_option_group("what");
  what->require_option(1);
  what->add_option("clip", *clip, "a take, by name or path, a geometry video's file, or a character's folder");
  auto is_live = std::make_shared<bool>(false);
  auto* live_flag = what->add_flag("--live", *is_live, "the surfaces that the daemon makes while cameras run");
  app->add_flag("--fullscreen", options->fullscreen, "fill the screen");
  auto* picture =
      app->add_option("--picture", live->picture,
                      "of live surfaces: write the newest, or the take's middle one, as a PNG; needs no display");
  app->add_option("--surfaces", live->surfaces, "so many come before the picture is written")
      ->needs(picture)
      ->needs(live_flag)
      ->check(CLI::PositiveNumber);
  app->footer(
      "A take that is not reconstructed yet is shown at live quality, as the daemon made it after the take.\n"
      "Keys: space pauses, arrows and mouse go round, + - zoom, . , step, g grey, q ends.\n"
      "Of a character: 1 to 9 states and actions, arrows turn it and its speed, F1 tells all.\n"
      "Examples:\n  rotunda play demo\n  rotunda play --live");
  app->callback([&line, clip, options, live, is_live] {
    line.run = [&line, clip, options, live, is_live](std::stop_token stop) {
      live->fullscreen = options->fullscreen;
      live->json = line.json;
      if (!*is_live) {
        if (const auto surfaces = only_live_surfaces(line, *clip))
          return show_live_take(*surfaces, *live, std::move(stop));
        if (!live->picture.empty())
          throw InvalidInput(*clip + " is reconstructed; for a picture of it: rotunda render " + *clip +
                             " -o view.png");
        return play(line, *clip, *options, std::move(stop));
      }
      live->socket = daemon_socket(line.daemon);
      return show_live(*live, std::move(stop));
    };
  });
}

void add_show(CommandLine& line) {
  auto clip = std::make_shared<std::string>();
  auto picture = std::make_shared<fs::path>();
  auto frame = std::make_shared<std::size_t>(0);
  auto* app = line.app.add_subcommand(
      "show", "what a geometry video or a character holds; a take, or its frames, as a picture");
  app->add_option("clip", *clip, "a take, by name or path, or a geometry video's file")->required();
  app->add_option("--picture", *picture, "write a contact sheet of the take, or frames of the geometry video (PNG)");
  app->add_option("--frame", *frame, "of the contact sheet")->capture_default_str();
  app->footer(
      "Examples:\n  rotunda show demo --picture contact.png\n"
      "  rotunda show takes/demo/recon/geometry.mkv --picture frames.png");
  app->callback([&line, clip, picture, frame] {
    line.run = [&line, clip, picture, frame](std::stop_token) { return show(line, *clip, *picture, *frame); };
  });
}

}  // namespace

void add_render_commands(CommandLine& line) {
  add_render(line);
  add_play(line);
  add_show(line);
}

}  // namespace rotunda::rig
