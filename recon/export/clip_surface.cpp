#include "recon/export/clip_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <system_error>

#include "capture/take/take.h"
#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {
namespace {

constexpr double kMostFrameRate = 1000.0;
constexpr double kOnFrame = 1e-6;  // of a frame: rates that divide each other meet their frames

}  // namespace

ClipExport::ClipExport(GeometryVideoReader& video, const ClipExportOptions& options)
    : video_(video), options_(options) {
  const auto& header = video.header();
  if (options_.end_frame == 0) options_.end_frame = header.frame_count();
  if (options_.first_frame < 0 || options_.first_frame >= options_.end_frame ||
      options_.end_frame > header.frame_count())
    throw InvalidInput(fmt::format("the geometry video holds the frames 0:{}, not {}:{}", header.frame_count(),
                                   options_.first_frame, options_.end_frame));
  if (options_.level == 0) options_.level = header.level;
  if (options_.level < kMinLatticeLevel || options_.level > header.level)
    throw InvalidInput(fmt::format("the geometry video is of level {}; export 1 to {}, not {}", header.level,
                                   header.level, options_.level));
  if (options_.fps == 0.0) options_.fps = header.fps;
  if (!(options_.fps > 0.0 && options_.fps <= kMostFrameRate))
    throw InvalidInput(fmt::format("{} frames a second are not to be had; up to {}", options_.fps, kMostFrameRate));
  report_.frames = static_cast<std::size_t>(count());
  for (int i = 0; i < count(); ++i)
    if (status(i).interpolated) ++report_.interpolated;
}

// From the first frame to the last.
int ClipExport::count() const {
  const double last = options_.end_frame - 1 - options_.first_frame;
  return static_cast<int>(std::floor(last * options_.fps / header().fps + kOnFrame)) + 1;
}

double ClipExport::place_of(int index) const {
  return std::min(options_.first_frame + index * header().fps / options_.fps, options_.end_frame - 1.0);
}

Eigen::Vector3d ClipExport::root(int index) const {
  const double place = place_of(index);
  const auto before = static_cast<std::size_t>(place + kOnFrame);
  const auto after = std::min(before + 1, header().root_path.size() - 1);
  const auto &a = header().root_path[before], &b = header().root_path[after];
  return a + std::max(0.0, place - static_cast<double>(before)) * (b - a);
}

FrameStatus ClipExport::status(int index) const {
  const double place = place_of(index);
  const auto& before = header().statuses[static_cast<std::size_t>(place + kOnFrame)];
  return before.interpolated ? before : header().statuses[static_cast<std::size_t>(std::ceil(place - kOnFrame))];
}

GeometryImage ClipExport::read(int index) {
  if (options_.stop.stop_requested())
    throw std::system_error(std::make_error_code(std::errc::operation_canceled), "export");
  auto image = video_.read_between(place_of(index), options_.level);
  ++read_;
  if (options_.progress) options_.progress(read_, report_.frames * static_cast<std::size_t>(passes_));
  return image;
}

std::string ClipExport::frame_name(int index, const char* extension) const {
  const auto number = video_.header().first_frame + options_.first_frame + index;
  return capture::frame_file_name(static_cast<std::size_t>(number), extension);
}

void ClipExport::set_surface(std::size_t vertices, std::size_t triangles) {
  report_.vertices = vertices;
  report_.triangles = triangles;
}

void ClipExport::written(const std::filesystem::path& file) {
  ++report_.files;
  report_.bytes += std::filesystem::file_size(file);
}

std::vector<Eigen::Vector3f> y_up(const std::vector<Eigen::Vector3f>& vectors) {
  std::vector<Eigen::Vector3f> turned;
  turned.reserve(vectors.size());
  for (const auto& v : vectors) turned.push_back(y_up(v));
  return turned;
}

std::vector<Eigen::Vector2f> texture_coordinates(int level, int colour_level) {
  const int side = lattice_side(level), stride = 1 << (colour_level - level);
  const auto at = [&](int i) {
    return (static_cast<float>(i * stride) + 0.5F) / static_cast<float>(lattice_side(colour_level));
  };
  std::vector<Eigen::Vector2f> coordinates;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) coordinates.emplace_back(at(x), at(y));
  return coordinates;
}

ClipExportReport export_clip(GeometryVideoReader& video, const ClipExportOptions& options) {
  ClipExport clip(video, options);
  const bool is_folder =
      options.format == ClipFormat::obj || options.format == ClipFormat::ply || options.format == ClipFormat::vat;
  const auto folder = is_folder ? options.output : options.output.parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  switch (options.format) {
    case ClipFormat::glb:
      export_glb(clip);
      break;
    case ClipFormat::obj:
      export_obj(clip);
      break;
    case ClipFormat::ply:
      export_ply(clip);
      break;
    case ClipFormat::vat:
      export_vat(clip);
      break;
    case ClipFormat::master:
      export_video(clip, VideoProfile::master);
      break;
    case ClipFormat::float32:
      export_video(clip, VideoProfile::float32);
      break;
    case ClipFormat::stream:
      export_video(clip, VideoProfile::stream);
      break;
    case ClipFormat::paper:
      export_paper(clip);
      break;
  }
  return clip.report();
}

}  // namespace rotunda::recon
