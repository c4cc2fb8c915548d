#pragma once
// Private to recon/export: what the formats share.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "recon/export/clip_export.h"
#include "recon/whole_file.h"

namespace rotunda::recon {

// One exporting of a clip: its options checked and filled in, frames read in order, files counted.
class ClipExport {
 public:
  ClipExport(GeometryVideoReader& video, const ClipExportOptions& options);

  int count() const;
  int level() const { return options_.level; }
  int colour_level() const { return video_.header().colour_level; }
  bool morph() const { return options_.morph; }
  double fps() const { return options_.fps; }
  const std::filesystem::path& output() const { return options_.output; }

  // How often every frame will be read, for the progress.
  void set_passes(int passes) { passes_ = passes; }
  // Counted from the first exported frame; tells progress, throws when stopped.
  GeometryImage read(int index);
  const GeometryVideoHeader& header() const { return video_.header(); }
  int first_frame() const { return options_.first_frame; }  // of the video
  Eigen::Vector3d root(int index) const;
  FrameStatus status(int index) const;                             // interpolated if one of the frames it is made of is
  std::string frame_name(int index, const char* extension) const;  // frame000012.obj
  void set_surface(std::size_t vertices, std::size_t triangles);
  void written(const std::filesystem::path& file);
  const ClipExportReport& report() const { return report_; }

 private:
  double place_of(int index) const;  // in the video's frames, counted from its first

  GeometryVideoReader& video_;
  ClipExportOptions options_;
  ClipExportReport report_;
  int passes_ = 1;
  std::size_t read_ = 0;
};

void export_glb(ClipExport& clip);
void export_obj(ClipExport& clip);
void export_ply(ClipExport& clip);
void export_vat(ClipExport& clip);
void export_video(ClipExport& clip, VideoProfile profile);
void export_paper(ClipExport& clip);

// World, z up, to glTF's frame: y up, the performer still faces the same way round.
inline Eigen::Vector3f y_up(const Eigen::Vector3f& v) {
  return {v.x(), v.z(), -v.y()};
}
std::vector<Eigen::Vector3f> y_up(const std::vector<Eigen::Vector3f>& vectors);

// Where the samples of a level lie in the colour image, raster order: middles of pixels, from the top left, 0 to 1.
std::vector<Eigen::Vector2f> texture_coordinates(int level, int colour_level);

}  // namespace rotunda::recon
