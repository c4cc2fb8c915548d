// rotunda mocap: a performer's motion out of a take's silhouettes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "playback/render/film_writer.h"
#include "recon/body/body_track.h"
#include "recon/body/motion_capture.h"
#include "recon/body/motion_overlay.h"
#include "recon/export/motion_glb.h"
#include "recon/take_outlines.h"
#include "recon/take_studio.h"
#include "rig/cli/command_line.h"
#include "rig/cli/frame_range.h"
#include "rig/cli/live_mocap.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct MocapArguments {
  std::string take, frames;
  fs::path output, joints, gltf, meshes, overlay, calibration, measures;
  double duration_s = 0.0;
  bool paper = false, live = false;
};

std::size_t count(const recon::CapturedMotion& motion, recon::TrackState state) {
  return static_cast<std::size_t>(std::count_if(motion.frames.begin(), motion.frames.end(),
                                                [&](const auto& frame) { return frame.state == state; }));
}

// Lost frames, stretch by stretch: "12:18 only 40 % ...".
std::vector<std::pair<std::string, std::string>> lost_stretches(const recon::CapturedMotion& motion) {
  std::vector<std::pair<std::string, std::string>> stretches;
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    if (motion.frames[i].state != recon::TrackState::lost) continue;
    std::size_t end = i + 1;
    while (end < motion.frames.size() && motion.frames[end].state == recon::TrackState::lost) ++end;
    stretches.emplace_back(fmt::format("{}:{}", motion.first_frame + i, motion.first_frame + end),
                           motion.frames[i].loss);
    i = end - 1;
  }
  return stretches;
}

json to_json(const recon::MotionCaptureReport& report) {
  const auto& motion = report.motion;
  json stages = json::array(), lost = json::array();
  for (const auto& cost : report.stages)
    stages.push_back(
        {{"stage", cost.stage}, {"count", cost.count}, {"median_ms", cost.median_ms}, {"cpu_s", cost.cpu_s}});
  for (const auto& [frames, why] : lost_stretches(motion)) lost.push_back({{"frames", frames}, {"reason", why}});
  double residual = 0.0;
  for (const auto& frame : motion.frames) residual += frame.fit.residual / static_cast<double>(motion.frames.size());
  return {{"frames", motion.frames.size()},
          {"lost", count(motion, recon::TrackState::lost)},
          {"recovered", count(motion, recon::TrackState::recovered)},
          {"lost_stretches", lost},
          {"start_frame", report.start_frame},
          {"height_m", recon::height_of(motion.body.measures)},
          {"mean_residual_m", residual},
          {"wall_s", report.wall_s},
          {"cpu_s", report.cpu_s},
          {"stages", stages}};
}

int tell(const CommandLine& line, const recon::MotionCaptureReport& report, const fs::path& output) {
  if (report.interrupted) {
    fmt::print(stderr, "interrupted; nothing is written\n");
    return kDoneWithLoss;
  }
  auto told = to_json(report);
  told["output"] = output.string();
  const auto lost = count(report.motion, recon::TrackState::lost);
  if (line.json) {
    fmt::print("{}\n", told.dump(2));
  } else {
    fmt::print("{} frames of a person {:.2f} m tall, from frame {}: {} lost, {} recovered; {:.1f} s, {:.1f} s CPU\n",
               report.motion.frames.size(), recon::height_of(report.motion.body.measures), report.start_frame, lost,
               count(report.motion, recon::TrackState::recovered), report.wall_s, report.cpu_s);
    fmt::print("{}\n", output.string());
  }
  for (const auto& [frames, why] : lost_stretches(report.motion))
    fmt::print(stderr, "lost in {}: {}; look at the mattes with `rotunda recon TAKE --frames {} --mattes DIR`\n",
               frames, why, frames);
  return lost == 0 ? kDone : kDoneWithLoss;
}

void write_overlay(const fs::path& take_folder, const MocapArguments& arguments, const recon::CapturedMotion& motion,
                   const std::stop_token& stop) {
  const capture::TakeReader take(take_folder);
  const auto studio = recon::read_take_studio(
      take, arguments.calibration.empty() ? std::nullopt : std::optional(arguments.calibration));
  std::unique_ptr<playback::FilmWriter> film;
  Progress bar("overlay");
  for (std::size_t i = 0; i < motion.frames.size() && !stop.stop_requested(); ++i) {
    const auto set = take.read(motion.first_frame + i);
    std::vector<cv::Mat> pictures;
    for (const auto& slot : set.slots) pictures.push_back(capture::picture_of(slot).rgb);
    const auto sheet = recon::overlay_picture(studio.views.cameras, pictures, motion.body, motion.frames[i]);
    if (!film)
      film =
          playback::make_film_writer(arguments.overlay, {.width = sheet.cols, .height = sheet.rows, .fps = motion.fps});
    cv::Mat rgba;
    cv::cvtColor(sheet, rgba, cv::COLOR_RGB2RGBA);
    film->write(rgba);
    bar.update(i + 1, motion.frames.size());
  }
  if (film && !stop.stop_requested()) film->finish();
}

void write_motion(const MocapArguments& arguments, const recon::CapturedMotion& motion) {
  if (!arguments.output.empty()) recon::write_bvh(arguments.output, recon::bvh_of(motion));
  if (!arguments.joints.empty()) recon::write_joints_json(arguments.joints, motion);
  if (!arguments.gltf.empty()) recon::write_motion_glb(arguments.gltf, motion);
  if (!arguments.meshes.empty()) recon::write_template_meshes(arguments.meshes, motion);
}

int capture_from_daemon(const CommandLine& line, const MocapArguments& arguments, std::stop_token stop) {
  if (!arguments.take.empty()) throw InvalidInput("name a take, or --live: not both");
  if (!arguments.overlay.empty() || !arguments.frames.empty() || !arguments.calibration.empty() || arguments.paper ||
      !arguments.measures.empty())
    throw InvalidInput("--overlay, --frames, --calibration, --measures and --paper are for takes, not for --live");
  const auto motion = capture_live(
      {.socket = daemon_socket(line.daemon), .seconds = arguments.duration_s, .json = line.json}, std::move(stop));
  if (motion.frames.empty()) {
    fmt::print(stderr, "nobody was found; nothing is written\n");
    return kDoneWithLoss;
  }
  write_motion(arguments, motion);
  fmt::print(stderr, "{} frames of a person {:.2f} m tall, {} lost{}\n", motion.frames.size(),
             recon::height_of(motion.body.measures), count(motion, recon::TrackState::lost),
             arguments.output.empty() ? "" : ": " + arguments.output.string());
  return kDone;
}

int capture_motion(const CommandLine& line, const MocapArguments& arguments, std::stop_token stop) {
  if (arguments.live) return capture_from_daemon(line, arguments, std::move(stop));
  if (arguments.take.empty()) throw InvalidInput("name a take, or give --live");
  if (arguments.output.empty()) throw InvalidInput("give -o, the BVH to write");
  const auto take = find_take(line, arguments.take);
  recon::MotionCaptureOptions options{.only_overlap = arguments.paper};
  if (!arguments.frames.empty()) options.frames = frame_range(arguments.frames);
  if (!arguments.measures.empty()) options.body = recon::read_joints_json(arguments.measures).body;
  recon::MotionCaptureReport report;
  {
    Progress bar("mocap " + take.filename().string());
    recon::TakeOutlines silhouettes(
        take, arguments.calibration.empty() ? std::nullopt : std::optional(arguments.calibration));
    report = recon::capture_motion(
        silhouettes, options, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, stop);
  }
  if (!report.interrupted) {
    write_motion(arguments, report.motion);
    if (!arguments.overlay.empty()) write_overlay(take, arguments, report.motion, stop);
  }
  return tell(line, report, arguments.output);
}

}  // namespace

void add_mocap_command(CommandLine& line) {
  auto arguments = std::make_shared<MocapArguments>();
  auto* mocap = line.app.add_subcommand("mocap", "captures a performer's motion from silhouettes, a take's or live");
  mocap->add_option("take", arguments->take, "a take's name in storage, or its path");
  mocap->add_option("-o", arguments->output, "the motion: BVH, centimetres, y up");
  auto* live = mocap->add_flag("--live", arguments->live,
                               "follow who is before the cameras now, until Ctrl-C or for --duration; with --json a "
                               "line a frame, joints in metres");
  mocap->add_option("--duration", arguments->duration_s, "seconds of live motion, from when somebody is found")
      ->needs(live)
      ->check(CLI::PositiveNumber);
  mocap->add_option("--joints", arguments->joints, "also write every joint's place, confidence and deviation (JSON)");
  mocap->add_option("--gltf", arguments->gltf, "also write the skeleton with the template on it (.glb)");
  mocap->add_option("--template", arguments->meshes, "also write DIR/frame000000.ply: the template in its pose");
  mocap->add_option("--overlay", arguments->overlay, "also write a film (.mp4) of the template over every view");
  mocap->add_option("--calibration", arguments->calibration, "use this instead of the take's own");
  mocap->add_option("--frames", arguments->frames, "A:B, half-open, counted from 0");
  mocap->add_option("--measures", arguments->measures,
                    "a --joints file of the same person in another take: their lengths and widths as found there");
  mocap->add_flag("--paper", arguments->paper, "silhouette overlap alone, as the paper: no expectation, no recovery");
  mocap->footer(
      "No ritual pose is needed, but somebody must stand or walk upright in some of the frames.\n"
      "Example:\n  rotunda mocap demo -o demo.bvh --joints joints.json --overlay demo-mocap.mp4\n"
      "  rotunda mocap jog -o jog.bvh --measures joints.json\n"
      "  rotunda mocap --live --duration 10 -o now.bvh");
  mocap->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return capture_motion(line, *arguments, std::move(stop)); };
  });
}

}  // namespace rotunda::rig
