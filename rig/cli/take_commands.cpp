// rotunda take start | stop | list | show | import | export.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/calibration/take_watch.h"
#include "capture/take/archive_manifest.h"
#include "capture/take/take.h"
#include "capture/take/take_edit.h"
#include "capture/take/take_export.h"
#include "capture/take/take_import.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json to_json(const TakeProgress& take) {
  return {{"name", take.name},         {"folder", take.folder.string()}, {"frame_sets", take.frame_sets},
          {"complete", take.complete}, {"closed", take.closed},          {"failure", take.failure},
          {"warnings", take.warnings}};
}

// Of a take that has closed, who moved is looked for here, in the client and after everybody else: recording the next
// one never waits for it.
std::vector<std::string> moved_cameras(const TakeProgress& take) {
  if (!take.closed || take.frame_sets == 0) return {};
  constexpr int kAfterEverybody = 19;
  [[maybe_unused]] const int nicer = nice(kAfterEverybody);
  return capture::moves_in_words(take.folder);
}

int tell_take(const TakeProgress& take, bool as_json) {
  if (!as_json)
    fmt::print("take {}: {} frame sets, {} complete{}\n  {}\n", take.name, take.frame_sets, take.complete,
               take.closed ? "" : ", recording; stop it with: rotunda take stop", take.folder.string());
  std::fflush(stdout);
  const auto moved = moved_cameras(take);
  if (as_json) {
    auto answer = to_json(take);
    answer["moved_cameras"] = moved;
    fmt::print("{}\n", answer.dump(2));
  }
  for (const auto& warning : take.warnings) fmt::print(stderr, "warning: {}\n", warning);
  for (const auto& camera : moved) fmt::print(stderr, "warning: {}\n", camera);
  if (!take.failure.empty()) {
    fmt::print(stderr, "rotunda: take {} ended early: {}\n", take.name, take.failure);
    return kDeviceFailed;
  }
  return take.closed && (take.complete < take.frame_sets || take.frame_sets == 0) ? kDoneWithLoss : kDone;
}

int start_take(const CommandLine& line, const TakeRequest& request, std::stop_token stop) {
  RigClient client(daemon_socket(line.daemon));
  const bool until_closed = request.duration_s > 0.0 || request.frame_sets > 0;
  TakeProgress take;
  {
    Progress bar("recording");
    take = client.start_take(
        request,
        [&](const TakeProgress& progress) {
          if (progress.wanted > 0) bar.update(progress.frame_sets, progress.wanted);
          // With a camera missing no frame set is complete: then the first there is has to do.
          const bool begun = progress.complete > 0 || (progress.frame_sets > 0 && !progress.warnings.empty());
          return until_closed || !begun;
        },
        stop);
  }
  return tell_take(take, line.json);
}

using Microseconds = std::chrono::duration<double, std::micro>;

json to_json(const capture::TakeCamera& camera, const capture::CameraSync& sync) {
  json reasons = json::object();
  for (const auto& [why, count] : camera.missing_because) reasons[std::string(to_string(why))] = count;
  return {{"name", camera.name},
          {"width", camera.width},
          {"height", camera.height},
          {"format", to_string(camera.format)},
          {"frames", camera.frames},
          {"missing", camera.missing},
          {"missing_because", reasons},
          {"offset_us", Microseconds(sync.offset).count()},
          {"jitter_us", Microseconds(sync.jitter).count()},
          {"drift_ppm", sync.drift_ppm}};
}

// What was measured of a camera's time; zeros for a take that has no such measurement.
capture::CameraSync sync_of(const capture::TakeInfo& info, std::size_t camera) {
  return camera < info.sync.cameras.size() ? info.sync.cameras[camera] : capture::CameraSync{};
}

json to_json(const capture::TakeInfo& info) {
  json cameras = json::array();
  for (std::size_t i = 0; i < info.cameras.size(); ++i) cameras.push_back(to_json(info.cameras[i], sync_of(info, i)));
  return {{"name", info.name},
          {"state", to_string(info.state)},
          {"fps", info.fps},
          {"rig", info.rig},
          {"recorded", info.recorded},
          {"slate", info.slate},
          {"scene", info.scene},
          {"shot", info.shot},
          {"take_number", info.take_number},
          {"circled", info.circled},
          {"note", info.note},
          {"frame_sets", info.frame_sets},
          {"complete", info.complete_sets},
          {"spread_median_us", Microseconds(info.sync.spread_median).count()},
          {"spread_p99_us", Microseconds(info.sync.spread_p99).count()},
          {"spread_max_us", Microseconds(info.sync.spread_max).count()},
          {"cameras", cameras}};
}

// As it stands in its folder: nobody records it any more, but nobody closed it either.
std::string state_word(const fs::path& folder, const capture::TakeInfo& info) {
  return capture::is_interrupted(folder, info) ? "interrupted" : std::string(to_string(info.state));
}

int list_takes(const CommandLine& line) {
  const auto root = takes_folder(line);
  std::vector<std::string> problems;
  const auto takes = capture::list_takes(root, &problems);
  if (line.json) {
    json list = json::array();
    for (const auto& take : takes) {
      list.push_back(to_json(take));
      list.back()["state"] = state_word(root / take.name, take);
    }
    fmt::print("{}\n", json{{"folder", root.string()}, {"takes", list}}.dump(2));
  } else {
    fmt::print("{:<20} {:<11} {:>10} {:>9} {:>8} {:>5}  {}\n", "take", "state", "frame sets", "complete", "cameras",
               "fps", "slate, note");
    for (const auto& take : takes)
      fmt::print("{:<20} {:<11} {:>10} {:>9} {:>8} {:>5}  {}{}{}{}\n", take.name, state_word(root / take.name, take),
                 take.frame_sets, take.complete_sets, take.cameras.size(), take.fps, take.circled ? "(*) " : "",
                 take.slate == take.name ? "" : take.slate, take.note.empty() || take.slate == take.name ? "" : ": ",
                 take.note);
    if (takes.empty()) fmt::print("no takes in {}\n", root.string());
  }
  for (const auto& problem : problems) fmt::print(stderr, "warning: {}\n", problem);
  return kDone;
}

void tell_camera(const capture::TakeCamera& camera, const capture::CameraSync& sync) {
  std::string causes;
  for (const auto& [why, count] : camera.missing_because)
    causes += fmt::format("{}{} {}", causes.empty() ? " (" : ", ", count, to_string(why));
  fmt::print("  {:<10} {} x {} {:<9} {} frames, {} missing{}{}", camera.name, camera.width, camera.height,
             to_string(camera.format), camera.frames, camera.missing, causes, causes.empty() ? "" : ")");
  fmt::print("; {:+.1f} us from the trigger, {:.1f} us jitter, {:+.2f} ppm\n", Microseconds(sync.offset).count(),
             Microseconds(sync.jitter).count(), sync.drift_ppm);
}

std::uintmax_t bytes_in(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

int show_take(const CommandLine& line, const std::string& name) {
  const auto folder = find_take(line, name);
  const capture::TakeReader reader(folder);
  const auto& info = reader.info();
  if (line.json) {
    auto answer = to_json(info);
    answer["archived"] = capture::is_archive(folder);
    answer["moved_cameras"] = capture::moves_in_words(folder);
    fmt::print("{}\n", answer.dump(2));
    return kDone;
  }
  fmt::print("{} ({})\n  {}, {} frame sets at {} Hz, {} complete\n", info.name, folder.string(),
             state_word(folder, info), info.frame_sets, info.fps, info.complete_sets);
  if (info.slate != info.name || info.circled)
    fmt::print("  slate: {}{}\n", info.slate, info.circled ? ", circled" : "");
  if (!info.recorded.empty())
    fmt::print("  recorded {}{}\n", info.recorded, info.rig.empty() ? "" : " by rig " + info.rig);
  if (!info.note.empty()) fmt::print("  note: {}\n", info.note);
  if (info.sync.sets > 0)
    fmt::print("  exposures of a frame set start within {:.1f} us (median), {:.1f} us (99 %), {:.1f} us (worst)\n",
               Microseconds(info.sync.spread_median).count(), Microseconds(info.sync.spread_p99).count(),
               Microseconds(info.sync.spread_max).count());
  for (std::size_t i = 0; i < info.cameras.size(); ++i) tell_camera(info.cameras[i], sync_of(info, i));
  for (const auto& mark : reader.journal().marks)
    fmt::print("  mark at frame {}: {}\n", mark.trigger - info.first_trigger, mark.text);
  for (const auto& incident : reader.journal().incidents)
    fmt::print("  at frame {}: {}\n", incident.trigger - info.first_trigger, incident.text);
  fmt::print("  {:.1f} MB on disk{}\n", static_cast<double>(bytes_in(folder)) / 1e6,
             capture::is_archive(folder) ? ", archived: as it was recorded by rotunda take restore" : "");
  for (const auto& problem : reader.problems()) fmt::print("  problem: {}\n", problem);
  for (const auto& camera : capture::moves_in_words(folder)) fmt::print("  problem: {}\n", camera);
  return kDone;
}

int import_take(const CommandLine& line, capture::TakeImportOptions options, std::stop_token stop) {
  options.takes = takes_folder(line);
  capture::TakeInfo info;
  {
    Progress bar("importing");
    info = capture::import_take(
        options, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, stop);
  }
  if (line.json)
    fmt::print("{}\n", to_json(info).dump(2));
  else
    fmt::print("take {}: {} frame sets of {} cameras\n  next: rotunda recon {}\n", info.name, info.frame_sets,
               info.cameras.size(), info.name);
  return kDone;
}

int export_take(const CommandLine& line, const std::string& name, const fs::path& folder, std::stop_token stop) {
  const capture::TakeReader reader(find_take(line, name));
  capture::TakeExportResult result;
  {
    Progress bar("exporting");
    result = capture::export_take(
        reader, folder, [&](std::size_t d, std::size_t n) { bar.update(d, n); }, stop);
  }
  if (line.json)
    fmt::print("{}\n", json{{"written", result.written}, {"missing", result.missing}}.dump(2));
  else
    fmt::print("{} pictures in {}, {} missing\n", result.written, folder.string(), result.missing);
  return result.missing > 0 ? kDoneWithLoss : kDone;
}

void add_start(CLI::App& take, CommandLine& line) {
  auto* start = take.add_subcommand("start", "records a take");
  auto request = std::make_shared<TakeRequest>();
  start->add_option("name", request->name, "the take's name (else the next free take001, take002, ...)");
  start->add_option("--duration", request->duration_s, "record so long, then return with the take closed")
      ->transform(seconds());
  start->add_option("--frames", request->frame_sets, "record so many frame sets")->check(CLI::PositiveNumber);
  start->add_option("--note", request->note, "a note kept with the take");
  start->add_option("--scene", request->scene, "on the slate; takes of one scene and shot are counted up");
  start->add_option("--shot", request->shot, "on the slate");
  start->footer(
      "Without --duration it returns when the first complete frame set is on disk.\n"
      "Example:\n  rotunda take start demo --duration 4s --note 'second try'\n"
      "  rotunda take start --scene 12 --shot B       12B-01, 12B-02, ...");
  start->callback([&line, request] {
    line.run = [&line, request](std::stop_token stop) { return start_take(line, *request, std::move(stop)); };
  });
}

void add_import(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("import", "makes a take of pictures from elsewhere");
  auto options = std::make_shared<capture::TakeImportOptions>();
  app->add_option("name", options->name, "the new take's name")->required();
  app->add_option("--images", options->images, "DIR/<camera>/*.png or *.jpg, in the order of their names")->required();
  app->add_option("--calibration", options->calibration, "calibration.yaml of these cameras")->required();
  app->add_option("--fps", options->fps, "frame sets a second")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 10000.0));
  app->add_option("--background", options->background, "DIR/<camera>.png: the empty studio");
  app->add_option("--mattes", options->mattes, "DIR/<camera>/*.png: given mattes, used instead of the key");
  app->footer("Example:\n  rotunda take import dance --images shots --calibration calibration.yaml --fps 30");
  app->callback([&line, options] {
    line.run = [&line, options](std::stop_token stop) { return import_take(line, *options, std::move(stop)); };
  });
}

void add_export(CLI::App& take, CommandLine& line) {
  auto folder = std::make_shared<fs::path>();
  auto* app = add_on_take(take, line, "export", "writes a take's frames as pictures",
                          [&line, folder](const std::string& name, std::stop_token stop) {
                            return export_take(line, name, *folder, std::move(stop));
                          });
  app->add_option("--images", *folder, "DIR/<camera>/frame000000.png")->required();
  app->footer("Example:\n  rotunda take export demo --images shots");
}

}  // namespace

CLI::App* add_on_take(CLI::App& take, CommandLine& line, const std::string& command, const std::string& what,
                      std::function<int(const std::string&, std::stop_token)> work) {
  auto* app = take.add_subcommand(command, what);
  auto name = std::make_shared<std::string>();
  app->add_option("take", *name, "a take's name in storage, or its path")->required();
  app->footer("Example:\n  rotunda take " + command + " demo");
  app->callback([&line, name, work = std::move(work)] {
    line.run = [name, work](std::stop_token stop) { return work(*name, std::move(stop)); };
  });
  return app;
}

void add_take_commands(CommandLine& line) {
  auto* take =
      line.app.add_subcommand("take", "records, checks, lists, imports and exports takes")->require_subcommand(1);
  add_start(*take, line);
  auto* stop = take->add_subcommand("stop", "stops the running take and waits until it is closed");
  stop->footer("Example:\n  rotunda take stop");
  stop->callback([&line] {
    line.run = [&line](std::stop_token) {
      return tell_take(RigClient(daemon_socket(line.daemon)).stop_take(), line.json);
    };
  });
  auto* list = take->add_subcommand("list", "the takes in storage");
  list->footer("Example:\n  rotunda take list --json");
  list->callback([&line] { line.run = [&line](std::stop_token) { return list_takes(line); }; });
  add_on_take(*take, line, "show", "what a take holds",
              [&line](const std::string& name, std::stop_token) { return show_take(line, name); });
  add_take_check_commands(*take, line);
  add_take_edit_commands(*take, line);
  add_take_archive_commands(*take, line);
  add_import(*take, line);
  add_export(*take, line);
}

}  // namespace rotunda::rig
