#pragma once
// Geometry video (Briceno et al. 2003; ALGORITHMS step 7): a sequence of geometry images in one Matroska file: streams
// of positions, colours and coverage, and the JSON header as an attachment before the first frame. How they are coded
// is the profile; a checksum in every frame of every stream. Named *.avi it is an AVI, JSON and mean beside it.
// Positions are stored without the root's translation, which stands in the header frame by frame. Metres, world frame,
// z up. Normals are not stored: they are read off the lattice. A file cut short keeps all frames before the cut.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "recon/sphere/geometry_image.h"
#include "recon/video/mean_surface.h"

namespace rotunda::recon {

struct FrameStatus {
  bool interpolated = false;  // this frame could not be mapped; what the video holds was made from its neighbours
  std::string reason;         // why, for people; empty for a mapped frame
};

enum class VideoProfile {
  master,   // positions: 16 bits of what they differ from their mean, or over the sequence's own box; all streams
            // lossless, every frame on its own (FFV1)
  float32,  // positions: the floats' own bits, in two streams; else as master
  stream,   // for sending: 12 bits of what positions differ from their mean over the sequence; lossy (HEVC)
};
std::string_view to_string(VideoProfile profile);  // "master", "float", "stream"

struct GeometryVideoHeader {
  int version = 1;  // as read; what is written has 4 for a master with a mean, 1 for one without, 2 for the others
  VideoProfile profile = VideoProfile::master;
  int level = 8;         // positions: (2^level + 1)^2
  int colour_level = 8;  // colours and coverage
  bool aligned = false;  // a sample is the same point of the performer in every frame
  double fps = 25.0;
  std::int64_t first_frame = 0;                 // the take's number of frame 0
  Eigen::AlignedBox3d box;                      // of all positions relative to their frame's root, metres
  bool from_mean = false;                       // positions are kept as what they differ from mean; stream: always
  Eigen::AlignedBox3d difference_box;           // from_mean: of the differences, equal in all axes; the writer fits it
  std::vector<Eigen::Vector3d> root_path;       // per frame, world, metres
  std::vector<FrameStatus> statuses;            // per frame
  std::vector<std::uint32_t> colour_checksums;  // version 4: CRC-32C of a frame's colours, red first, row by row

  int frame_count() const { return static_cast<int>(root_path.size()); }
};

// The root of one surface: its area's centroid, which follows the body's translation and not its turning. World.
Eigen::Vector3d root_of(const GeometryImage& image);

// Takes one frame into the header: its root, its status, and the box grows around it. The first sets the levels;
// throws InvalidInput if a later one has others, or a position is not finite.
void add_frame(GeometryVideoHeader& header, const GeometryImage& image, FrameStatus status = {});

std::string to_json(const GeometryVideoHeader& header);
// Throws CorruptData: not JSON, another version, a value that cannot be.
GeometryVideoHeader header_from_json(const std::string& json);

// The header must hold every frame before the first is written. The file takes its name in finish(); destroyed before
// that, nothing is left. Throws InvalidInput (a frame of another level, a position outside the box, too many or too
// few frames) and std::system_error.
class GeometryVideoWriter {
 public:
  // mean: of the very frames of the header. A stream needs it; a master may have it, and is smaller by what samples
  // keep to from frame to frame.
  GeometryVideoWriter(const std::filesystem::path& file, const GeometryVideoHeader& header,
                      const MeanSurface& mean = {});
  ~GeometryVideoWriter();
  GeometryVideoWriter(const GeometryVideoWriter&) = delete;
  GeometryVideoWriter& operator=(const GeometryVideoWriter&) = delete;

  void write(const GeometryImage& image);  // the next frame
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The whole in one call, every frame mapped, without a mean.
void write_geometry_video(const std::filesystem::path& file, std::span<const GeometryImage> images, double fps = 25.0);

// image + share (other - image): what lies between two frames whose samples correspond, of one size, in what they hold
// (both read alike). Covered is what both cover.
void blend(GeometryImage& image, const GeometryImage& other, float share);

struct FrameReadOptions {
  int level = 0;          // of detail: every 2^k-th sample, a closed surface of its own; 0: the video's
  bool in_place = false;  // without the root's translation
  bool drawn = false;     // positions and colours alone, as renderers take them; no normals, no coverage
};

// Frames in any order; cheapest in sequence. Throws std::system_error (no such file), CorruptData (with file, offset
// and what is wrong) and InvalidInput (no such frame).
class GeometryVideoReader {
 public:
  explicit GeometryVideoReader(const std::filesystem::path& file);
  ~GeometryVideoReader();
  GeometryVideoReader(GeometryVideoReader&&) noexcept;
  GeometryVideoReader& operator=(GeometryVideoReader&&) noexcept;

  const GeometryVideoHeader& header() const;
  int frame_count() const;

  // In the world. A coarser level takes every 2^k-th sample of the positions; colours stay as fine as they are.
  GeometryImage read(int frame);
  GeometryImage read(int frame, int level);
  GeometryImage read(int frame, const FrameReadOptions& options);
  // The same without the root's translation.
  GeometryImage read_in_place(int frame, int level);
  // Between frames, for another frame rate: `at` counts frames from 0 and may be a fraction. Positions and colours are
  // blended where samples correspond (aligned), else the nearest frame serves; what either frame made up is uncovered.
  GeometryImage read_between(double at, int level);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rotunda::recon
