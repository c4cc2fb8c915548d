#include "recon/frame_store.h"

#include <fmt/format.h>

#include "config/errors.h"
#include "recon/geometry_image_file.h"
#include "recon/mesh/mesh_file.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace fs = std::filesystem;

fs::path FrameStore::folder_of(const fs::path& take) {
  return take / "recon" / "frames";
}

FrameStore::FrameStore(fs::path folder, const std::string& settings) : folder_(std::move(folder)) {
  const auto settings_file = folder_ / "settings.json";
  if (fs::exists(folder_) && read_text(settings_file) != settings) fs::remove_all(folder_);
  fs::create_directories(folder_);
  write_text(settings_file, settings);
}

fs::path FrameStore::path(std::size_t frame, const char* ending) const {
  return folder_ / fmt::format("frame{:06}{}", frame, ending);
}

bool FrameStore::finished(std::size_t frame) const {
  return fs::exists(path(frame, ".colour.png")) || fs::exists(path(frame, ".failed"));
}

std::optional<std::string> FrameStore::failure(std::size_t frame) const {
  const auto file = path(frame, ".failed");
  if (!fs::exists(file)) return std::nullopt;
  return read_text(file);
}

void FrameStore::save(std::size_t frame, const MappedSurface& surface, const GeometryImage& image) const {
  write_ply(path(frame, ".ply"), surface.mesh);
  write_directions(path(frame, ".sphere.tiff"), surface.map.points);
  const auto unfinished = path(frame, ".unfinished.png");
  write_geometry_image(path(frame, ".tiff"), unfinished, image);
  fs::rename(unfinished, path(frame, ".colour.png"));
}

void FrameStore::save_report(std::size_t frame, const std::string& json) const {
  write_text(path(frame, ".json"), json + "\n");
}

void FrameStore::save_failure(std::size_t frame, const std::string& reason) const {
  write_text(path(frame, ".failed"), reason);
}

MappedSurface FrameStore::surface(std::size_t frame) const {
  MappedSurface surface{.mesh = read_ply(path(frame, ".ply")), .map = {read_directions(path(frame, ".sphere.tiff"))}};
  if (surface.map.points.size() != surface.mesh.positions.size())
    throw CorruptData(path(frame, ".sphere.tiff").string() + ": is not the sphere map of the mesh beside it");
  return surface;
}

GeometryImage FrameStore::image(std::size_t frame) const {
  return read_geometry_image(path(frame, ".tiff"), path(frame, ".colour.png"));
}

}  // namespace rotunda::recon
