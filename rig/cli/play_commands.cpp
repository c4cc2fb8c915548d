// rotunda play, show: takes, geometry videos, characters and the rig live, in a window; what they hold.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/character_window.h"
#include "playback/contact_sheet.h"
#include "playback/paper_figures.h"
#include "playback/player.h"
#include "recon/live_take.h"
#include "recon/motion/character.h"
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
    fmt::print("{}\n", json{{"pictures", report.pictures},
                            {"seconds", report.seconds},
                            {"load_s", report.load_seconds},
                            {"lost_contexts", report.lost_contexts}}
                           .dump(2));
  return kDone;
}

int play(const CommandLine& line, const std::string& clip, playback::PlayOptions options,
         const ViewDependent& view_dependent, std::stop_token stop) {
  options.pictures = chosen_pictures(line, clip, view_dependent);
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
                            {"seconds", report.seconds},
                            {"lost_contexts", report.lost_contexts}}
                           .dump(2));
  return kDone;
}

json header_report(const recon::GeometryVideoHeader& header) {
  json failed = json::array();
  for (int i = 0; i < header.frame_count(); ++i)
    if (header.statuses[static_cast<std::size_t>(i)].interpolated)
      failed.push_back(
          {{"frame", header.first_frame + i}, {"reason", header.statuses[static_cast<std::size_t>(i)].reason}});
  const Eigen::Vector3d size = header.box.sizes(), way = header.root_path.back() - header.root_path.front();
  return {{"version", header.version},
          {"profile", recon::to_string(header.profile)},
          {"frames", header.frame_count()},
          {"first_frame", header.first_frame},
          {"fps", header.fps},
          {"level", header.level},
          {"colour_level", header.colour_level},
          {"aligned", header.aligned},
          {"box_m", {size.x(), size.y(), size.z()}},
          {"root_moved_m", way.norm()},
          {"interpolated", failed}};
}

void print_contents(const recon::GeometryVideoHeader& header, const json& report) {
  fmt::print("{} frames from {} on at {} Hz, level {}, {}, {} interpolated\n", header.frame_count(), header.first_frame,
             header.fps, header.level, header.aligned ? "aligned" : "not aligned", report["interpolated"].size());
  const Eigen::Vector3d size = header.box.sizes();
  fmt::print(
      "profile {}, version {}, colours of level {}; within {:.2f} x {:.2f} x {:.2f} m about the root, which moves "
      "{:.2f} m\n",
      recon::to_string(header.profile), header.version, header.colour_level, size.x(), size.y(), size.z(),
      report["root_moved_m"].get<double>());
  for (const auto& frame : report["interpolated"])
    fmt::print("  frame {} interpolated: {}\n", frame["frame"].get<std::int64_t>(), frame["reason"].get<std::string>());
}

int draw_figure(const CommandLine& line, const std::string& clip, const fs::path& picture, std::size_t frame,
                int figure) {
  const auto take = find_take(line, clip);
  const playback::ContactSheetOptions options{.frame = frame, .tile_width = 240, .tile_height = 320};
  const auto draw = figure == 1   ? playback::figure_of_stages
                    : figure == 2 ? playback::figure_of_alignment
                                  : playback::figure_of_quantisation;
  capture::write_png(picture, draw(take, options));
  if (!line.json) fmt::print("{}\n", picture.string());
  return kDone;
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
    print_contents(video.header(), report);
  return kDone;
}

void add_play(CommandLine& line) {
  auto clip = std::make_shared<std::string>();
  auto options = std::make_shared<playback::PlayOptions>();
  auto live = std::make_shared<LiveViewRequest>();
  auto view_dependent = std::make_shared<ViewDependent>();
  auto* app = line.app.add_subcommand(
      "play", "plays a take's geometry video or the rig live, or steers a character, in a window");
  auto* what = app->add_option_group("what");
  what->require_option(1);
  what->add_option("clip", *clip, "a take, by name or path, a geometry video's file, or a character's folder");
  auto is_live = std::make_shared<bool>(false);
  auto* live_flag = what->add_flag("--live", *is_live, "the surfaces that the daemon makes while cameras run");
  app->add_flag("--fullscreen", options->fullscreen, "fill the screen");
  add_view_dependent(*app, *view_dependent);
  app->add_option("--level", options->level, "of detail, (2^level + 1)^2 vertices; else as fine as the geometry video")
      ->check(CLI::Range(1, 12));
  auto* picture =
      app->add_option("--picture", live->picture,
                      "of live surfaces: write the newest, or the take's middle one, as a PNG; needs no display");
  app->add_option("--surfaces", live->surfaces, "so many come before the picture is written")
      ->needs(picture)
      ->needs(live_flag)
      ->check(CLI::PositiveNumber);
  app->footer(
      "A take that is not reconstructed yet is shown at live quality, as the daemon made it after the take.\n"
      "Keys: space freezes, arrows and mouse go round, + - zoom, . , step, q ends; F1 tells all.\n"
      "Of a character: 1 to 9 states and actions, arrows turn it and its speed, F1 tells all.\n"
      "Examples:\n  rotunda play demo\n  rotunda play demo --view-dependent\n  rotunda play --live");
  app->callback([&line, clip, options, live, is_live, view_dependent] {
    line.run = [&line, clip, options, live, is_live, view_dependent](std::stop_token stop) {
      live->fullscreen = options->fullscreen;
      live->json = line.json;
      if (!*is_live) {
        if (const auto surfaces = only_live_surfaces(line, *clip))
          return show_live_take(*surfaces, *live, std::move(stop));
        if (!live->picture.empty())
          throw InvalidInput(*clip + " is reconstructed; for a picture of it: rotunda render " + *clip +
                             " -o view.png");
        return play(line, *clip, *options, *view_dependent, std::move(stop));
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
  app->add_option("--frame", *frame, "of the contact sheet or figure")->capture_default_str();
  auto figure = std::make_shared<int>(0);
  app->add_option(
         "--figure", *figure,
         "with --picture, of a take: as the first paper's figure 1 (one frame through the stages), 2 (geometry "
         "images before and after alignment) or 4 (quantised at 1 cm, not quantised, view-dependent)")
      ->check(CLI::IsMember({1, 2, 4}));
  app->footer(
      "Examples:\n  rotunda show demo --picture contact.png\n  rotunda show demo --figure 1 --picture stages.png\n"
      "  rotunda show takes/demo/recon/geometry.mkv --picture frames.png");
  app->callback([&line, clip, picture, frame, figure] {
    line.run = [&line, clip, picture, frame, figure](std::stop_token) {
      if (*figure == 0) return show(line, *clip, *picture, *frame);
      if (picture->empty()) throw InvalidInput("--figure is a picture; say with --picture FILE.png where it goes");
      return draw_figure(line, *clip, *picture, *frame, *figure);
    };
  });
}

}  // namespace

void add_play_commands(CommandLine& line) {
  add_play(line);
  add_show(line);
}

}  // namespace rotunda::rig
