// rotunda animate: anyone's motion on anyone's scan.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "playback/marker_window.h"
#include "playback/render/animation_film.h"
#include "playback/render/scan_video.h"
#include "recon/export/animation_export.h"
#include "recon/mesh/scan_file.h"
#include "recon/motion/character.h"
#include "rig/cli/command_line.h"
#include "rig/cli/motion_source.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct AnimateArguments {
  MotionSource motion;
  fs::path scan, markers, output, write_markers, edit, picture;
  std::string to;
  double turns = 1.0;
  bool as_paper = false, view_dependent = false, beside_template = false;
};

recon::PreparedScan read_prepared(const fs::path& file) {
  auto read = recon::read_scan(file);
  auto scan = recon::prepare_scan(read.mesh);
  scan.notes.insert(scan.notes.begin(), read.notes.begin(), read.notes.end());
  return scan;
}

// How good a fit must be for its markers to be trusted: half of the surface within 15 mm of the template, and no more
// than two fifths that belongs to nothing (skirts, hair, what a person holds).
void judge(const recon::TemplateFit& fit) {
  if (fit.distance < 0.015 && fit.far_share < 0.4) return;
  throw InvalidInput(fmt::format(
      "the body template does not fit the scan: half of it is farther than {:.0f} mm away, {:.0f} % belongs to no part "
      "of the body. Scan the person in an A- or T-pose, alone, in close clothes; or place markers by hand (--edit)",
      1000.0 * fit.distance, 100.0 * fit.far_share));
}

recon::Markers markers_for(const AnimateArguments& arguments, const recon::PreparedScan& scan) {
  if (!arguments.markers.empty()) {
    auto markers = recon::read_markers(arguments.markers);
    if (!markers.fit) markers.fit = recon::fit_template(scan.mesh);
    return markers;
  }
  const auto fit = recon::fit_template(scan.mesh);
  judge(fit);
  return recon::propose_markers(scan.mesh, scan.from_triangle, fit);
}

// What is edited first: the markers given, else those of the file that is edited, else proposed ones; where a template
// does not fit, a person may still see what can be done.
recon::Markers markers_to_edit(const AnimateArguments& arguments, const recon::PreparedScan& scan) {
  AnimateArguments chosen = arguments;
  if (chosen.markers.empty() && fs::exists(arguments.edit)) chosen.markers = arguments.edit;
  try {
    return markers_for(chosen, scan);
  } catch (const InvalidInput& error) {
    if (!chosen.markers.empty()) throw;
    fmt::print(stderr, "{}\n", error.what());
  }
  return recon::propose_markers(scan.mesh, scan.from_triangle, recon::fit_template(scan.mesh));
}

void go_on_with(recon::MarkerEditor& editor, const recon::Markers& left, const fs::path& unsaved) {
  try {
    editor.replace(left.pairs);
  } catch (const InvalidInput& error) {
    throw InvalidInput(
        fmt::format("{}: left without saving, of another scan? Move it away. {}", unsaved.string(), error.what()));
  }
}

// The editor; the markers as they are when it is closed.
recon::Markers edit(const AnimateArguments& arguments, const recon::PreparedScan& scan, const recon::BodyMotion& motion,
                    const std::stop_token& stop) {
  if (const auto folder = fs::absolute(arguments.edit).parent_path(); !fs::is_directory(folder))
    throw InvalidInput(fmt::format("--edit {}: there is no folder {}", arguments.edit.string(), folder.string()));
  recon::MarkerKeeper keeper(arguments.edit, arguments.scan.filename().string());
  recon::MarkerEditor editor(scan, markers_to_edit(arguments, scan));
  if (const auto left = keeper.left()) {
    go_on_with(editor, *left, keeper.unsaved());
    fmt::print(stderr, "{}: goes on where it was left without saving (u takes that back)\n", keeper.unsaved().string());
  }
  if (!arguments.picture.empty()) {
    capture::write_png(arguments.picture, playback::picture_of_markers(scan, editor, motion));
    return editor.markers();
  }
  playback::edit_markers(scan, editor, keeper, motion, {.stop = stop});
  if (editor.changed())
    fmt::print(stderr, "{}: not saved; the next --edit {} goes on from there\n", keeper.unsaved().string(),
               arguments.edit.string());
  return editor.markers();
}

recon::AnimationFormat format_of(const AnimateArguments& arguments) {
  if (arguments.to == "skin") return recon::AnimationFormat::skin;
  if (arguments.to == "morph") return recon::AnimationFormat::morph;
  return recon::AnimationFormat::pc2;
}

// What the file's name asks for where --to does not.
std::string kind_of(const AnimateArguments& arguments) {
  const auto extension = arguments.output.extension();
  const std::string by_name = extension == ".glb"                          ? "skin"
                              : extension == ".obj"                        ? "pc2"
                              : extension == ".png" || extension == ".mp4" ? "film"
                                                                           : "";
  if (by_name.empty()) throw InvalidInput(arguments.output.string() + ": write a .glb, .obj (with .pc2), .png or .mp4");
  if (arguments.to.empty()) return by_name;
  if ((arguments.to == "pc2") != (by_name == "pc2") || by_name == "film")
    throw InvalidInput(fmt::format("--to {} is for {}", arguments.to, arguments.to == "pc2" ? ".obj" : ".glb"));
  return arguments.to;
}

void tell(const std::vector<std::string>& notes, const fs::path& about, bool as_json) {
  for (const auto& note : notes)
    if (!as_json) fmt::print("{}: {}\n", about.string(), note);
}

void report(const recon::AnimationExportReport& report, const AnimateArguments& arguments,
            const recon::ScanAnimation& animation, double bind_s, const json& notes, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", json{{"output", arguments.output.string()},
                            {"frames", report.frames},
                            {"vertices", report.vertices},
                            {"triangles", report.triangles},
                            {"bytes", report.bytes},
                            {"bind_s", bind_s},
                            {"deform_s", report.deform_s},
                            {"drift_mm", 1000.0 * report.drift},
                            {"volume", report.has_volume ? json{report.least_volume, report.most_volume} : json()},
                            {"skin_rms_mm", 1000.0 * report.skin_rms},
                            {"skin_worst_mm", 1000.0 * report.skin_worst},
                            {"template_distance_mm", 1000.0 * animation.fit().distance},
                            {"notes", notes}}
                           .dump(2));
    return;
  }
  fmt::print("{}: {} frames of {} triangles, {:.1f} MB\n", arguments.output.string(), report.frames, report.triangles,
             static_cast<double>(report.bytes) / 1e6);
  fmt::print("bound in {:.1f} s, {:.0f} frames a second; markers drift {:.1f} mm\n", bind_s,
             static_cast<double>(report.frames) / std::max(report.deform_s, 1e-9), 1000.0 * report.drift);
  if (report.has_volume)
    fmt::print("volume {:+.1f} to {:+.1f} %\n", 100.0 * (report.least_volume - 1.0),
               100.0 * (report.most_volume - 1.0));
  if (report.skin_worst > 0.0)
    fmt::print("the skin is {:.1f} mm (rms) from the surface, {:.0f} mm at the worst; --to morph is exact\n",
               1000.0 * report.skin_rms, 1000.0 * report.skin_worst);
}

void check(const AnimateArguments& arguments) {
  if (arguments.output.empty() && arguments.edit.empty()) throw InvalidInput("give -o, what to write; or --edit");
  if (!arguments.motion.clip.empty() && !recon::is_character(arguments.motion.file))
    throw InvalidInput(
        fmt::format("--clip names a clip of a character, and {} is none: give the character's folder as "
                    "--motion",
                    arguments.motion.file.string()));
  if (arguments.view_dependent && !arguments.edit.empty())
    throw InvalidInput("--edit shows the scan itself: edit the markers first, then --view-dependent --markers");
  if (!arguments.view_dependent) {
    if (arguments.beside_template) throw InvalidInput("--beside-template compares 3D videos: add --view-dependent");
    if (arguments.motion.calibration && !is_take(arguments.motion))
      throw InvalidInput("--calibration says where a take's cameras stand, and --motion is no take");
    return;
  }
  if (!is_take(arguments.motion))
    throw InvalidInput("--view-dependent colours the scan by the pictures of a take: give the take as --motion");
  if (arguments.output.extension() != ".mp4" && !arguments.output.extension().empty())
    throw InvalidInput(arguments.output.string() + ": a 3D video is a .mp4, or a folder of pictures");
}

// The performer's legs in a scan and in a take differ by less: shoes, a template's faults.
constexpr double kSameLegs = 0.06;

// 3D video: the scan where the performer was, in the pictures of the take.
int film_video(const CommandLine& line, const AnimateArguments& arguments, const std::stop_token& stop) {
  auto scan = read_prepared(arguments.scan);
  tell(scan.notes, arguments.scan, line.json);
  const auto markers = markers_for(arguments, scan);
  recon::ScanAnimation animation(std::move(scan), markers, {.as_paper = arguments.as_paper});
  tell(animation.notes(), arguments.scan, line.json);
  const auto motion = capture(line, arguments.motion, stop);
  const double legs = animation.fit().body.skeleton.leg_length(), theirs = motion.body.skeleton.leg_length();
  if (std::abs(legs / theirs - 1.0) > kSameLegs)
    fmt::print(
        stderr,
        "{}: its legs are {:.2f} m long, those in the take {:.2f} m: another person's pictures will not fit it\n",
        arguments.scan.string(), legs, theirs);
  Progress bar("rendering");
  playback::ScanVideoOptions options{.output = arguments.output,
                                     .take = find_take(line, arguments.motion.file),
                                     .calibration = arguments.motion.calibration,
                                     .beside_template = arguments.beside_template,
                                     .turns = arguments.turns};
  options.progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); };
  options.stop = stop;
  playback::write_scan_video(animation, motion, options);
  if (line.json)
    fmt::print("{}\n", json{{"output", arguments.output.string()}, {"frames", motion.frames.size()}}.dump(2));
  return kDone;
}

int animate(const CommandLine& line, const AnimateArguments& arguments, std::stop_token stop) {
  check(arguments);
  if (arguments.view_dependent) return film_video(line, arguments, stop);
  const std::string kind = arguments.output.empty() ? "" : kind_of(arguments);
  const auto motion = read_motion(line, arguments.motion, stop);
  tell(motion.notes, arguments.motion.file, line.json);
  auto scan = read_prepared(arguments.scan);
  tell(scan.notes, arguments.scan, line.json);
  json notes = motion.notes;
  for (const auto& note : scan.notes) notes.push_back(note);
  const auto markers = arguments.edit.empty() ? markers_for(arguments, scan) : edit(arguments, scan, motion, stop);
  if (arguments.output.empty()) return kDone;
  if (!arguments.write_markers.empty())
    recon::write_markers(arguments.write_markers, markers, arguments.scan.filename().string());
  const auto start = std::chrono::steady_clock::now();
  recon::ScanAnimation animation(std::move(scan), markers, {.as_paper = arguments.as_paper});
  const double bind_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  tell(animation.notes(), arguments.scan, line.json);
  const auto poses = animation.handle_poses(motion);
  Progress bar("animate");
  const auto progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); };
  if (kind == "film") {
    playback::write_animation_film(
        animation, poses,
        {.output = arguments.output, .frame_time = motion.frame_time, .progress = progress, .stop = stop});
    return kDone;
  }
  AnimateArguments chosen = arguments;
  chosen.to = kind;
  const auto done = recon::export_animation(animation, poses,
                                            {.format = format_of(chosen),
                                             .output = arguments.output,
                                             .frame_time = motion.frame_time,
                                             .progress = progress,
                                             .stop = stop});
  report(done, arguments, animation, bind_s, notes, line.json);
  return kDone;
}

}  // namespace

void add_animate_command(CommandLine& line) {
  auto arguments = std::make_shared<AnimateArguments>();
  auto* app = line.app.add_subcommand("animate", "moves a body scan as somebody moved");
  app->add_option(
         "--motion", arguments->motion.file,
         "FILE.bvh: anyone's motion capture; or a take, a geometry video (.mkv) or a character, whose is captured")
      ->required();
  app->add_option("--clip", arguments->motion.clip, "of the character: walk, idle-walk, ...");
  app->add_option("--scan", arguments->scan,
                  "FILE.ply, .obj, .glb or .gltf, with its pictures: a person in an A- or T-pose, any size of mesh")
      ->required()
      ->check(CLI::ExistingFile);
  app->add_option("--markers", arguments->markers,
                  "pairs of triangles, as --write-markers writes them; else found by fitting a body to the scan")
      ->check(CLI::ExistingFile);
  app->add_option("--write-markers", arguments->write_markers, "write the markers used, to be edited");
  app->add_option("-o,--output", arguments->output,
                  "FILE.glb, FILE.obj (with FILE.pc2), FILE.mp4, or FILE.png: a sheet");
  auto* edit = app->add_option("--edit", arguments->edit,
                               "open an editor of the markers beside the template: s saves them to this file, F1 tells "
                               "the keys; -o is written with them once it is closed");
  app->add_option("--picture", arguments->picture, "FILE.png of the editor instead of its window")->needs(edit);
  app->add_option("--to", arguments->to,
                  "skin (a .glb's default: small, its error is told), morph (.glb: exact, large), pc2 (.obj: exact)")
      ->check(CLI::IsMember({"skin", "morph", "pc2"}));
  app->add_option("--frames", arguments->motion.frames, "A:B of the motion, half-open, counted from 0");
  app->add_flag("--paper", arguments->as_paper,
                "as de Aguiar et al. 2007: nothing held in place but by least squares, volume left to itself");
  app->add_flag("--trust-angles", arguments->motion.trust_angles,
                "take a BVH's angles as degrees though they look like radians");
  app->add_flag("--view-dependent", arguments->view_dependent,
                "3D video: the performer's own scan where they were, in the colours of the take's pictures, as a film");
  app->add_flag("--beside-template", arguments->beside_template,
                "3D video: and to the right of it the motion capture's template in the same pictures");
  app->add_option("--turns", arguments->turns, "3D video: of the eye round the performer")->capture_default_str();
  app->add_option("--calibration", arguments->motion.calibration, "of the take, if not its own")
      ->check(CLI::ExistingFile);
  app->footer(
      "Examples:\n  rotunda animate --motion dance.bvh --scan scan.ply -o dance.glb\n"
      "  rotunda animate --motion alex --clip kick --scan scan.ply -o kick.glb\n"
      "  rotunda animate --motion demo --scan scan.ply --view-dependent -o video.mp4\n"
      "  rotunda animate --motion dance.bvh --scan scan.ply --write-markers markers.yaml -o dance.mp4\n"
      "  rotunda animate --motion dance.bvh --scan scan.ply --edit markers.yaml\n"
      "  rotunda animate --motion dance.bvh --scan scan.ply --markers markers.yaml --to pc2 -o dance.obj");
  app->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return animate(line, *arguments, std::move(stop)); };
  });
}

}  // namespace rotunda::rig
