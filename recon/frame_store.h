#pragma once
// What the reconstruction of a take keeps of each finished frame, so that it can go on where it was interrupted:
//   recon/frames/frame000012.ply          the closed surface (world, metres)
//   recon/frames/frame000012.sphere.tiff   its sphere map: a row of three doubles a vertex
//   recon/frames/frame000012.tiff         the geometry image's positions, float
//   recon/frames/frame000012.colour.png   its colours, with coverage as alpha
//   recon/frames/frame000012.json         what was found out on the way (frame_report.h)
//   recon/frames/frame000012.failed       instead of surface and image: why the frame failed
// A frame counts as finished once its last file is there; settings.json beside them says what they were made with.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/geometry_image.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// A frame's surface and where each vertex lies on the sphere.
struct MappedSurface {
  TriangleMesh mesh;
  SphereMap map;
};

class FrameStore {
 public:
  static std::filesystem::path folder_of(const std::filesystem::path& take);

  // For reading what is there.
  explicit FrameStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // Frames made with other settings (a JSON text) than these are deleted. Throws std::system_error.
  FrameStore(std::filesystem::path folder, const std::string& settings);

  bool finished(std::size_t frame) const;  // mapped or failed
  std::optional<std::string> failure(std::size_t frame) const;

  void save(std::size_t frame, const MappedSurface& surface, const GeometryImage& image) const;
  void save_failure(std::size_t frame, const std::string& reason) const;

  void save_report(std::size_t frame, const std::string& json) const;  // before the frame itself: its last file ends it

  // Throw CorruptData if a file is damaged.
  MappedSurface surface(std::size_t frame) const;
  GeometryImage image(std::size_t frame) const;  // normals read off the lattice

 private:
  std::filesystem::path path(std::size_t frame, const char* ending) const;

  std::filesystem::path folder_;
};

}  // namespace rotunda::recon
