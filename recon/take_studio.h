#pragma once
// What a take says about the studio it was recorded in: cameras in the take's order, clean plates, backdrop, volume.
#include <filesystem>
#include <optional>
#include <vector>

#include "capture/take/take_reader.h"
#include "recon/frame_reconstruction.h"
#include "recon/sphere/geometry_image.h"

namespace rotunda::recon {

struct TakeStudio {
  StudioViews views;
  std::optional<Eigen::AlignedBox3d> volume;  // of the rig, world, metres; none for takes from elsewhere
  std::string unit;                           // of the calibration
};

// `calibration`: instead of the take's own. Throws InvalidInput that tells every camera which is missing in the
// calibration or of another size; ConfigError, CorruptData.
TakeStudio read_take_studio(const capture::TakeReader& take, const std::optional<std::filesystem::path>& calibration);

// The mattes that came with the take, a slot per camera; an empty alpha where there is none.
std::vector<capture::Matte> given_mattes(const capture::TakeReader& take, std::size_t frame);

// Where a take's geometry video lies.
std::filesystem::path geometry_video_of(const std::filesystem::path& take);
// One frame's closed surface as the reconstruction left it; nothing if it failed or was not made.
std::optional<TriangleMesh> frame_surface(const std::filesystem::path& take, std::size_t frame);
// Its geometry image by its own map, before frames were aligned; likewise.
std::optional<GeometryImage> frame_image(const std::filesystem::path& take, std::size_t frame);

}  // namespace rotunda::recon
