#include "recon/frame_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace rotunda::recon {

double unseen_share(const GeometryImage& image) {
  if (image.coverage.empty()) return 0.0;
  const auto unseen = std::count(image.coverage.begin(), image.coverage.end(), std::uint8_t{0});
  return static_cast<double>(unseen) / static_cast<double>(image.coverage.size());
}

std::string frame_report(std::size_t frame, const std::string& failure, const SurfaceReport& surface,
                         std::optional<double> unseen) {
  nlohmann::json report{{"frame", frame}};
  if (!failure.empty()) report["failure"] = failure;
  report["triangles"] = surface.triangles;
  report["volume"] = surface.volume;
  report["area"] = surface.area;
  report["euler_characteristic"] = surface.topology.euler_characteristic;
  report["components"] = surface.cut.pieces.pieces;
  report["handles_cut_voxels"] = surface.cut.cut_voxels;
  report["filled_voxels"] = surface.cut.filled_voxels;
  report["dropped_voxels"] = surface.cut.pieces.dropped_voxels;
  if (surface.cut.pieces.tied > 0) report["tied_components"] = surface.cut.pieces.tied;
  report["rims"] = surface.rims;
  if (!surface.disagreeing.empty()) report["disagreeing_cameras"] = surface.disagreeing;
  for (const auto& back : surface.put_back) report["put_back_share"][back.camera] = back.share;
  for (const auto& denied : surface.denied) report["denied_share"][denied.camera] = denied.share;
  if (unseen) report["unseen_share"] = *unseen;
  report["stages"] = nlohmann::json::array();
  for (const auto& stage : surface.stages)
    report["stages"].push_back({{"stage", stage.name}, {"wall_ms", stage.wall_ms}, {"cpu_ms", stage.cpu_ms}});
  return report.dump();
}

}  // namespace rotunda::recon
