// rotunda recon, map: takes to geometry videos, one mesh to the sphere and back.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "recon/alignment_report.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_file.h"
#include "recon/sphere/sphere_map.h"
#include "recon/stage_clock.h"
#include "recon/take_reconstruction.h"
#include "recon/video/geometry_picture.h"
#include "rig/cli/command_line.h"
#include "rig/cli/frame_range.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json to_json(const std::vector<recon::StageCost>& stages) {
  json list = json::array();
  for (const auto& stage : stages)
    list.push_back({{"stage", stage.stage},
                    {"count", stage.count},
                    {"median_ms", stage.median_ms},
                    {"median_cpu_ms", stage.median_cpu_ms},
                    {"cpu_s", stage.cpu_s}});
  return list;
}

json to_json(const recon::TakeAlignmentReport& report) {
  json frames = json::array();
  for (const auto& frame : report.frames) frames.push_back(recon::json_of(frame));
  json result{{"how", report.how}, {"frames", frames}, {"stages", to_json(report.stages)}};
  if (!report.why_no_skeleton.empty()) result["why_no_skeleton"] = report.why_no_skeleton;
  return result;
}

json to_json(const recon::TakeReconstructionReport& report) {
  json failed = json::array();
  for (const auto& frame : report.failed) failed.push_back({{"frame", frame.frame}, {"reason", frame.reason}});
  return {{"video", report.video.string()},
          {"frames", report.frames},
          {"mapped", report.mapped},
          {"resumed", report.resumed},
          {"failed", failed},
          {"interrupted", report.interrupted},
          {"wall_s", report.wall_s},
          {"cpu_s", report.cpu_s},
          {"stages", to_json(report.stages)},
          {"cameras", json::parse(recon::to_json(report.cameras))},
          {"alignment", report.alignment ? to_json(*report.alignment) : json()},
          {"unaligned", report.unaligned}};
}

// Frames of which the carried surface misses a good part, as half-open runs of neighbours.
void print_missed(const std::vector<recon::FrameAlignment>& frames, const std::string& take) {
  constexpr double kMissed = 0.15;  // of the surface: an arm and more
  for (auto frame = frames.begin(); frame != frames.end();) {
    frame = std::find_if(frame, frames.end(), [](const auto& f) { return f.uncovered > kMissed; });
    if (frame == frames.end()) return;
    const auto begin = frame;
    double most = 0.0;
    for (; frame != frames.end() && frame->uncovered > kMissed; ++frame) most = std::max(most, frame->uncovered);
    fmt::print(
        "  frames {}:{} do not fit: up to {:.0f} % of their surface is not reached. See what the motion is there with "
        "`rotunda mocap {} -o motion.bvh --overlay motion.mp4`, or leave them out with --frames\n",
        begin->frame, std::prev(frame)->frame + 1, 100.0 * most, take);
  }
}

void print_alignment(const recon::TakeReconstructionReport& report, const std::string& take) {
  if (!report.unaligned.empty()) fmt::print("frames are not aligned: {}\n", report.unaligned);
  if (!report.alignment || report.alignment->frames.empty()) return;
  const auto& frames = report.alignment->frames;
  double mean = 0.0, p95 = 0.0, stretch = 1.0;
  std::size_t folds = 0;
  for (const auto& frame : frames) {
    mean += frame.residual_mean_mm / static_cast<double>(frames.size());
    p95 = std::max(p95, frame.residual_p95_mm);
    stretch = std::max(stretch, frame.stretch_p95);
    folds += frame.folds;
  }
  fmt::print(
      "{} frames aligned by {}: {:.1f} mm from their own surfaces (mean; worst frame's 95 % within {:.1f} mm), {} "
      "folds, "
      "stretch {:.2f}\n",
      frames.size(), report.alignment->how, mean, p95, folds, stretch);
  if (!report.alignment->why_no_skeleton.empty())
    fmt::print("  no skeleton, so surfaces were followed from frame to frame: {}\n", report.alignment->why_no_skeleton);
  print_missed(frames, take);
}

void print_report(const recon::TakeReconstructionReport& report, const std::string& take) {
  fmt::print("{:<10} {:>6} {:>12} {:>12} {:>9}\n", "stage", "runs", "median ms", "CPU ms", "CPU s");
  for (const auto& stage : report.stages)
    fmt::print("{:<10} {:>6} {:>12.1f} {:>12.1f} {:>9.1f}\n", stage.stage, stage.count, stage.median_ms,
               stage.median_cpu_ms, stage.cpu_s);
  fmt::print("{} of {} frames mapped ({} from an earlier run) in {:.1f} s, {:.1f} s CPU\n", report.mapped,
             report.frames, report.resumed, report.wall_s, report.cpu_s);
  print_alignment(report, take);
  for (const auto& frame : report.failed) fmt::print("  frame {} failed: {}\n", frame.frame, frame.reason);
  if (!report.video.empty()) fmt::print("{}\n", report.video.string());
}

// Once over the whole take: no camera is blamed frame by frame.
void tell_moved(const recon::TakeReconstructionReport& report) {
  for (const auto& standing : report.cameras)
    if (standing.shift && standing.shift->moved)
      fmt::print(stderr, "warning: {}; fasten it and calibrate anew\n", recon::in_words(standing));
}

int tell(const recon::TakeReconstructionReport& report, const std::string& take, bool as_json) {
  tell_moved(report);
  if (as_json)
    fmt::print("{}\n", to_json(report).dump(2));
  else
    print_report(report, take);
  if (report.interrupted) fmt::print(stderr, "interrupted; the same command goes on where it stopped\n");
  if (report.mapped == 0 && !report.interrupted) {
    fmt::print(stderr, "rotunda: no frame could be reconstructed; first reason: {}\n", report.failed.front().reason);
    return kBadInput;
  }
  return report.failed.empty() && !report.interrupted ? kDone : kDoneWithLoss;
}

struct ReconArguments {
  std::string take, frames, reference, quality = "full";
  fs::path calibration, meshes, mattes;
  std::vector<double> performer_at;  // none, or x and y
  std::optional<int> colour_level;
  bool align = false, no_align = false;
  recon::TakeReconstructionOptions options;
};

recon::Alignment alignment_of(const ReconArguments& arguments) {
  using recon::Alignment;
  if (!arguments.reference.empty()) return Alignment::always;
  if (arguments.align) return Alignment::always;
  return arguments.no_align || arguments.quality == "live" ? Alignment::none : Alignment::where_it_fits;
}

int reconstruct(const CommandLine& line, ReconArguments arguments, std::stop_token stop) {
  auto& options = arguments.options;
  options.take = find_take(line, arguments.take);
  if (!arguments.frames.empty()) options.frames = frame_range(arguments.frames);
  if (!arguments.calibration.empty()) options.calibration = arguments.calibration;
  if (!arguments.meshes.empty()) options.meshes = arguments.meshes;
  if (!arguments.mattes.empty()) options.mattes = arguments.mattes;
  if (arguments.performer_at.size() == 2) options.performer_at = Eigen::Vector2d(arguments.performer_at.data());
  if (!arguments.reference.empty()) options.reference = find_take(line, arguments.reference);
  options.align = alignment_of(arguments);
  if (arguments.quality == "live") {
    options.quality = recon::Quality::live;
    options.level = options.colour_level = 7;
  }
  if (arguments.colour_level) options.colour_level = *arguments.colour_level;
  if (options.colour_level < options.level || options.colour_level > options.level + 2)
    throw InvalidInput(
        fmt::format("--colour-level {}: colours are as fine as positions (level {}) or up to two levels finer",
                    options.colour_level, options.level));
  recon::TakeReconstructionReport report;
  {
    Progress bar("recon " + options.take.filename().string());
    report = recon::reconstruct_take(
        options, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, std::move(stop));
  }
  return tell(report, arguments.take, line.json);
}

struct MapArguments {
  fs::path mesh, sphere, remesh, image;
  int level = 8;
};

json to_json(const recon::SphereMapReport& report) {
  return {
      {"flips", report.flips},
      {"splits", report.splits},
      {"area_error", report.area_error},
      {"area_per_vertex",
       {{"min", report.spread.min}, {"p5", report.spread.p5}, {"p50", report.spread.p50}, {"p95", report.spread.p95}}},
      {"failure", report.failure}};
}

void write_results(const MapArguments& arguments, const recon::TriangleMesh& mesh, const recon::SphereMap& map) {
  if (!arguments.sphere.empty()) recon::write_sphere_ply(arguments.sphere, mesh, map);
  if (arguments.remesh.empty() && arguments.image.empty()) return;
  const auto image = recon::resample(mesh, map, arguments.level);
  if (!arguments.remesh.empty()) recon::write_ply(arguments.remesh, recon::remesh(image));
  if (!arguments.image.empty()) capture::write_png(arguments.image, recon::position_picture(image));
}

bool has_area(const recon::TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  constexpr float kNothing = 1e-7F;  // of the squared longest side: what float positions can tell
  const auto &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  const float longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() > kNothing * longest;
}

// Marching cubes makes one here and there; the map gives them room like all others. Many tell that the mesh is damaged.
void refuse_triangles_without_area(const fs::path& file, const recon::TriangleMesh& mesh) {
  constexpr std::size_t kOneIn = 1000;
  std::size_t flat = 0, first = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!has_area(mesh, mesh.triangles[t]) && flat++ == 0) first = t;
  if (flat * kOneIn > mesh.triangles.size())
    throw InvalidInput(fmt::format("{}: triangle {} has no area; remove such triangles first", file.string(), first));
  if (flat > 0)
    fmt::print(stderr, "rotunda: {}: {} triangle(s) of no area, the first {}: mapped as they are\n", file.string(),
               flat, first);
}

int map_mesh(const CommandLine& line, const MapArguments& arguments) {
  const auto mesh = recon::read_mesh(arguments.mesh);
  refuse_triangles_without_area(arguments.mesh, mesh);
  recon::StageClock clock;
  const auto result = clock.run("sphere", [&] { return recon::map_to_sphere(mesh); });
  if (result.map) clock.run("write", [&] { write_results(arguments, mesh, *result.map); });
  auto report = to_json(result.report);
  report["triangles"] = mesh.triangles.size();
  report["cpu_s"] = clock.costs().front().cpu_s;
  if (line.json)
    fmt::print("{}\n", report.dump(2));
  else if (result.map)
    fmt::print(
        "{} triangles on the sphere in {:.2f} s CPU: {} flips, area per vertex p5 / p95 {:.2f} / {:.2f} of the mean\n",
        mesh.triangles.size(), clock.costs().front().cpu_s, result.report.flips, result.report.spread.p5,
        result.report.spread.p95);
  if (result.map) return kDone;
  fmt::print(stderr, "rotunda: {}: {}\n", arguments.mesh.string(), result.report.failure);
  return kBadInput;
}

}  // namespace

void add_recon_commands(CommandLine& line) {
  auto arguments = std::make_shared<ReconArguments>();
  auto& options = arguments->options;
  auto* recon = line.app.add_subcommand("recon", "reconstructs a take's surface and writes its geometry video");
  recon->add_option("take", arguments->take, "a take's name in storage, or its path")->required();
  recon->add_option("--quality", arguments->quality, "live (the live key, a quarter of the samples) or full")
      ->check(CLI::IsMember({"live", "full"}))
      ->capture_default_str();
  recon->add_flag("--paper", options.paper,
                  "as the first paper: the photo hull, and its 24-bit geometry.avi beside the video");
  recon->add_option("--cell", options.cell_size, "edge of a hull cell (10mm where the unit is metres)")
      ->transform(metres())
      ->check([](const std::string& length) {
        return std::stod(length) > 0.0 ? std::string() : "a cell's edge is longer than nothing, as 10mm";
      });
  recon
      ->add_option(
          "--tolerate-misses", options.tolerate_misses,
          "so many mattes may lack a part that all others show (0); recon/frames/*.json tell how much each did")
      ->check(CLI::Range(0, 8));
  recon
      ->add_option("--performer", arguments->performer_at,
                   "X,Y: of several people the one nearest to this place on the floor (the largest)")
      ->delimiter(',')
      ->expected(2);
  recon
      ->add_option("--tie", options.tied_litres,
                   "keep also what touches nobody and has at least so many litres, on a thread (a ball, a second "
                   "person); else it is left out")
      ->check(CLI::Range(0.01, 1e6));
  recon->add_option("--triangles", options.triangles, "of the surface before mapping")
      ->check(CLI::Range(500, 200000))
      ->capture_default_str();
  recon->add_option("--colour-level", arguments->colour_level,
                    "(2^level + 1)^2 colours: as many as positions (8; live: 7), or up to two levels more");
  auto* align = recon->add_flag("--align", arguments->align,
                                "sample every frame at the same points of the performer (so without this, too, unless "
                                "that leaves out a prop or a wide skirt; not with --quality live)");
  recon->add_flag("--no-align", arguments->no_align, "sample each frame on its own")->excludes(align);
  recon->add_option("--reference", arguments->reference,
                    "another take of the same person, aligned: align this one to its points");
  recon->add_option("--calibration", arguments->calibration, "use this instead of the take's own");
  recon->add_option("--frames", arguments->frames, "A:B, half-open, counted from 0");
  recon->add_option("--jobs", options.jobs, "frames at once (else one a core)")->check(CLI::Range(1, 256));
  recon->add_option("--meshes", arguments->meshes, "also write DIR/frame000000.ply: the closed surface before mapping");
  recon->add_option("--mattes", arguments->mattes, "also write DIR/<camera>/frame000000.png");
  recon->footer(
      "Finished frames are kept: an interrupted run goes on where it stopped.\n"
      "Examples:\n  rotunda recon walk\n  rotunda recon jog --reference walk\n"
      "  rotunda recon demo --frames 0:25 --meshes surfaces");
  recon->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return reconstruct(line, *arguments, std::move(stop)); };
  });

  auto mapping = std::make_shared<MapArguments>();
  auto* map = line.app.add_subcommand("map", "maps one closed mesh to the sphere and back");
  map->add_option("mesh", mapping->mesh, "a closed genus-0 mesh (PLY or OBJ)")->required();
  map->add_option("--level", mapping->level, "2^level + 1 samples a side")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  map->add_option("--sphere", mapping->sphere, "write the mesh's vertices on the unit sphere (PLY, double)");
  map->add_option("--remesh", mapping->remesh, "write the surface read back from the geometry image (PLY)");
  map->add_option("-o", mapping->image, "write the geometry image as a picture (PNG)");
  map->footer("Example:\n  rotunda map body.ply --level 8 --sphere sphere.ply --remesh remesh.ply -o image.png");
  map->callback(
      [&line, mapping] { line.run = [&line, mapping](std::stop_token) { return map_mesh(line, *mapping); }; });
}

}  // namespace rotunda::rig
