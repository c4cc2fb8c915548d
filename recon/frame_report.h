#pragma once
// What the reconstruction found out about one frame, as a line of JSON.
#include <optional>
#include <string>

#include "recon/hull/surface.h"
#include "recon/sphere/geometry_image.h"

namespace rotunda::recon {

// Share of the image's colour samples that no camera saw, 0 to 1.
double unseen_share(const GeometryImage& image);

// {"frame", "failure" or the surface's "triangles", "volume", "area" (the calibration's unit cubed and squared),
// "euler_characteristic", "components", "handles_cut_voxels", "filled_voxels", "dropped_voxels", "rims",
// "disagreeing_cameras": whose mattes the others do not support, as of a camera that was moved, "put_back_share":
// {camera: of its silhouette, what it had lost and the others put back}, "denied_share": {camera: of the solid, where
// misses are tolerated}, "unseen_share", "stages": [{"stage", "wall_ms", "cpu_ms"}]}.
std::string frame_report(std::size_t frame, const std::string& failure, const SurfaceReport& surface,
                         std::optional<double> unseen);

}  // namespace rotunda::recon
