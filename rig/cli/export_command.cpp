// rotunda export: geometry videos for other programs.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "recon/export/clip_export.h"
#include "recon/motion/character.h"
#include "rig/cli/clip_choice.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

const std::map<std::string, recon::ClipFormat> kFormats{
    {"glb", recon::ClipFormat::glb},       {"obj", recon::ClipFormat::obj},       {"ply", recon::ClipFormat::ply},
    {"vat", recon::ClipFormat::vat},       {"master", recon::ClipFormat::master}, {"float", recon::ClipFormat::float32},
    {"stream", recon::ClipFormat::stream}, {"paper", recon::ClipFormat::paper}};

std::string extension_of(recon::ClipFormat format) {
  switch (format) {
    case recon::ClipFormat::glb:
      return ".glb";
    case recon::ClipFormat::paper:
      return ".avi";
    case recon::ClipFormat::master:
    case recon::ClipFormat::float32:
    case recon::ClipFormat::stream:
      return ".mkv";
    default:
      return "";  // folders
  }
}

struct ExportArguments {
  std::string clip, format, frames;
  recon::ClipExportOptions options;
};

void tell(const recon::ClipExportReport& report, const recon::ClipExportOptions& options, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", nlohmann::json{{"output", options.output.string()},
                                      {"frames", report.frames},
                                      {"interpolated", report.interpolated},
                                      {"vertices", report.vertices},
                                      {"triangles", report.triangles},
                                      {"files", report.files},
                                      {"bytes", report.bytes}}
                           .dump(2));
    return;
  }
  fmt::print("{}: {} frames of {} vertices, {} triangles, {:.1f} MB in {} file(s)\n", options.output.string(),
             report.frames, report.vertices, report.triangles, static_cast<double>(report.bytes) / 1e6, report.files);
  if (report.interpolated > 0)
    fmt::print("{} frames could not be reconstructed and are made from their neighbours\n", report.interpolated);
}

// Every clip of a character, under its own name, in a folder.
int export_character(const CommandLine& line, const ExportArguments& arguments, std::stop_token stop) {
  const auto graph = recon::open_character(arguments.clip);
  const auto& folder = arguments.options.output;
  if (folder.has_extension())
    throw InvalidInput(
        fmt::format("a character is exported to a folder, a file a clip; {} looks like a file", folder.string()));
  std::filesystem::create_directories(folder);
  for (const auto& clip : graph.clips) {
    recon::GeometryVideoReader video(recon::clip_video_of(arguments.clip, clip.name));
    auto options = arguments.options;
    options.format = kFormats.at(arguments.format);
    options.stop = stop;
    options.output = folder / (clip.name + extension_of(options.format));
    recon::ClipExportReport report;
    {
      Progress bar("export " + clip.name);
      options.progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); };
      report = recon::export_clip(video, options);
    }
    tell(report, options, line.json);
  }
  return kDone;
}

int export_video(const CommandLine& line, ExportArguments arguments, std::stop_token stop) {
  if (recon::is_character(arguments.clip)) return export_character(line, arguments, std::move(stop));
  auto& options = arguments.options;
  const auto source = find_video(line, arguments.clip);
  recon::GeometryVideoReader video(source);
  if (std::filesystem::exists(options.output) && std::filesystem::equivalent(options.output, source))
    throw InvalidInput(options.output.string() + " is the clip itself; give the new file another name");
  options.format = kFormats.at(arguments.format);
  if (options.morph && options.format != recon::ClipFormat::glb) throw InvalidInput("--morph is for --to glb");
  std::tie(options.first_frame, options.end_frame) = chosen_frames(arguments.frames, std::nullopt, video.header());
  options.stop = std::move(stop);
  recon::ClipExportReport report;
  {
    Progress bar("export " + arguments.format);
    options.progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); };
    report = recon::export_clip(video, options);
  }
  tell(report, options, line.json);
  return kDone;
}

}  // namespace

void add_export_command(CommandLine& line) {
  auto arguments = std::make_shared<ExportArguments>();
  auto* app = line.app.add_subcommand("export", "writes a geometry video for Blender, Unreal, Unity and others");
  app->add_option("clip", arguments->clip, "a take, by name or path, a geometry video's file, or a character's folder")
      ->required();
  app->add_option("--to", arguments->format,
                  "glb (one file, animated), obj or ply (a file a frame), vat (vertex animation texture); "
                  "or a geometry video: master (lossless), float (every bit), stream (small), paper (24-bit AVI)")
      ->required()
      ->check(CLI::IsMember(kFormats));
  app->add_option("-o,--output", arguments->options.output,
                  "FILE.glb; FILE.mkv, master and float also FILE.avi, paper FILE.avi; obj, ply, vat, and of a "
                  "character always: a folder")
      ->required();
  app->add_option("--frames", arguments->frames, "A:B, half-open, counted from 0");
  app->add_option("--level", arguments->options.level, "(2^level + 1)^2 vertices; else as fine as the geometry video")
      ->check(CLI::Range(1, 12));
  app->add_option(
         "--fps", arguments->options.fps,
         "frames a second; frames between the video's own are made where it is aligned, else the nearest serves")
      ->check(CLI::Range(0.1, 1000.0));
  app->add_flag("--morph", arguments->options.morph,
                "glb: one mesh with a morph target a frame, the first frame's colours for all");
  app->footer(
      "Examples:\n  rotunda export demo --to glb --level 7 -o demo.glb\n"
      "  rotunda export demo --to obj --frames 0:25 -o demo-obj\n"
      "  rotunda export demo --to stream -o demo.mkv\n"
      "  rotunda export demo --to master --fps 60 -o smooth.mkv\n"
      "  rotunda export alex --to glb --level 6 -o alex-clips");
  app->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return export_video(line, *arguments, std::move(stop)); };
  });
}

}  // namespace rotunda::rig
