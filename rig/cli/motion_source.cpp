#include "rig/cli/motion_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "config/errors.h"
#include "config/progress.h"
#include "recon/body/motion_capture.h"
#include "recon/motion/character.h"
#include "recon/take_outlines.h"
#include "recon/video/surface_outlines.h"
#include "rig/cli/frame_range.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;

bool is_video(const fs::path& file) {
  return fs::is_regular_file(file) && (file.extension() == ".mkv" || file.extension() == ".avi");
}

// A character's clip, by --clip.
fs::path clip_of(const MotionSource& source) {
  const auto graph = recon::open_character(source.file);
  std::vector<std::string> names;
  for (const auto& clip : graph.clips) {
    if (clip.name == source.clip) return recon::clip_video_of(source.file, clip.name);
    names.push_back(clip.name);
  }
  throw InvalidInput(
      fmt::format("{}: say with --clip which of its clips: {}", source.file.string(), fmt::join(names, ", ")));
}

std::unique_ptr<recon::OutlineSource> silhouettes_of(const CommandLine& line, const MotionSource& source) {
  if (is_take(source)) return std::make_unique<recon::TakeOutlines>(find_take(line, source.file), source.calibration);
  return std::make_unique<recon::SurfaceOutlines>(is_video(source.file) ? source.file : clip_of(source));
}

}  // namespace

bool is_take(const MotionSource& source) {
  return !fs::is_regular_file(source.file) && !recon::is_character(source.file);
}

recon::CapturedMotion capture(const CommandLine& line, const MotionSource& source, const std::stop_token& stop) {
  recon::MotionCaptureOptions options;
  if (!source.frames.empty()) options.frames = frame_range(source.frames);
  const auto silhouettes = silhouettes_of(line, source);
  Progress bar("mocap " + source.file.filename().string());
  auto report = recon::capture_motion(
      *silhouettes, options, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, stop);
  if (report.interrupted)
    throw std::system_error(std::make_error_code(std::errc::operation_canceled), "stopped before the motion was whole");
  return std::move(report.motion);
}

recon::BodyMotion read_motion(const CommandLine& line, const MotionSource& source, const std::stop_token& stop) {
  const bool is_captured = is_take(source) || is_video(source.file) || recon::is_character(source.file);
  const recon::BvhImportOptions options{.name = source.file.filename().string(),
                                        .trust_angles = source.trust_angles || is_captured};
  if (is_captured) return recon::import_bvh(recon::bvh_of(capture(line, source, stop)), options);
  auto motion = recon::import_bvh(recon::read_bvh(source.file), options);
  if (source.frames.empty()) return motion;
  const auto [first, end] = frame_range(source.frames);
  const auto last = std::min(end, motion.poses.size());
  if (first >= last)
    throw InvalidInput(
        fmt::format("frames {} are not in the motion, which has 0:{}", source.frames, motion.poses.size()));
  motion.poses = {motion.poses.begin() + static_cast<std::ptrdiff_t>(first),
                  motion.poses.begin() + static_cast<std::ptrdiff_t>(last)};
  return motion;
}

}  // namespace rotunda::rig
