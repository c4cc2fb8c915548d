#pragma once
// Geometry video as the paper stores it (Starck, Miller, Hilton 2005, 3.3; ALGORITHMS step 7): an AVI of 24-bit
// pictures, 2^n by 2^n, whose first (2^n - 1)^2 pixels are the lattice without its border; red, green, blue are x, y, z
// relative to the root, 255 levels of 1 cm about it (128 is the root, 0 is not used). A second video stream of the
// same size holds the colours. The JSON beside it is a geometry video's header; the root path stands there.
// What is lost: half a centimetre, and everything farther than 1.27 m from the root along an axis is clipped.
#include <filesystem>
#include <span>

#include "recon/video/geometry_video.h"

namespace rotunda::recon {

class PaperVideoWriter {
 public:
  // Throws InvalidInput for a header that no geometry video could have, std::system_error if the disk refuses.
  PaperVideoWriter(const std::filesystem::path& avi, const std::filesystem::path& json,
                   const GeometryVideoHeader& header);
  ~PaperVideoWriter();
  PaperVideoWriter(const PaperVideoWriter&) = delete;
  PaperVideoWriter& operator=(const PaperVideoWriter&) = delete;

  void write(const GeometryImage& image);  // the next frame
  void finish();                           // both files take their names

 private:
  struct State;
  std::unique_ptr<State> state_;
};

void write_paper_video(const std::filesystem::path& avi, const std::filesystem::path& json,
                       std::span<const GeometryImage> images, double fps = 25.0);

// What is left of a frame after it was stored so: positions relative to `root` at whole centimetres, colours at the
// positions' level, the border filled as below.
GeometryImage as_paper_stores(const GeometryImage& image, const Eigen::Vector3d& root);

// Reads it back in the world. The border is filled by the mean of the interior samples that meet there: the paper
// keeps it open. Colours are at the positions' level. Throws CorruptData and std::system_error.
class PaperVideoReader {
 public:
  PaperVideoReader(const std::filesystem::path& avi, const std::filesystem::path& json);
  ~PaperVideoReader();
  const GeometryVideoHeader& header() const;
  GeometryImage read(int frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rotunda::recon
