#include <fmt/format.h>

#include <cmath>

#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"
#include "recon/video/media_file.h"

namespace rotunda::recon {
namespace {

constexpr double kSteps = 65535.0;

MediaFileOptions media_options(const GeometryVideoHeader& header) {
  const auto streams = geometry_video_streams(header);
  return {.container = "matroska",
          .fps = header.fps,
          .streams = {streams.begin(), streams.end()},
          .attachments = {{"geometry.json", kHeaderMimeType, to_json(header)}}};
}

std::vector<cv::Mat> quantise(const GeometryImage& image, const Eigen::AlignedBox3d& box, const Eigen::Vector3d& root) {
  const int side = image.side();
  std::vector<cv::Mat> planes;
  for (int axis = 0; axis < 3; ++axis) {
    cv::Mat plane(side, side, CV_16UC1);
    const double low = box.min()[axis] + root[axis], extent = box.sizes()[axis];
    const double steps_per_metre = extent > 0.0 ? kSteps / extent : 0.0;
    auto* step = plane.ptr<std::uint16_t>();
    for (const Eigen::Vector3f& position : image.positions) {
      const double value = std::round((static_cast<double>(position[axis]) - low) * steps_per_metre);
      if (!(value >= -1.0 && value <= kSteps + 1.0))  // one step of slack for rounding; not so for NaN
        throw InvalidInput("a position lies outside the geometry video's box; was the frame added to the header?");
      *step++ = static_cast<std::uint16_t>(std::clamp(value, 0.0, kSteps));
    }
    planes.push_back(std::move(plane));
  }
  return planes;
}

cv::Mat colour_plane(const GeometryImage& image) {
  cv::Mat plane(image.colour_side(), image.colour_side(), CV_8UC4);
  auto* bgr0 = plane.ptr<cv::Vec4b>();
  for (const Colour& c : image.colours) *bgr0++ = {c[2], c[1], c[0], 0};
  return plane;
}

}  // namespace

struct GeometryVideoWriter::State {
  GeometryVideoHeader header;
  MediaWriter media;
  int written = 0;
};

GeometryVideoWriter::GeometryVideoWriter(const std::filesystem::path& file, const GeometryVideoHeader& header) {
  static_cast<void>(header_from_json(to_json(header)));  // what we write, we can read
  state_.reset(new State{header, {file, media_options(header)}, 0});
}

GeometryVideoWriter::~GeometryVideoWriter() = default;

void GeometryVideoWriter::write(const GeometryImage& image) {
  const GeometryVideoHeader& header = state_->header;
  if (state_->written >= header.frame_count())
    throw InvalidInput(
        fmt::format("the geometry video's header holds {} frames, one more was written", header.frame_count()));
  const auto samples = static_cast<std::size_t>(image.side()) * static_cast<std::size_t>(image.side());
  const auto texels = static_cast<std::size_t>(image.colour_side()) * static_cast<std::size_t>(image.colour_side());
  if (image.level != header.level || image.colour_level != header.colour_level || image.positions.size() != samples ||
      image.colours.size() != texels || image.coverage.size() != texels)
    throw InvalidInput(fmt::format("frame {} of the geometry video is not of level {} with colours of level {}",
                                   state_->written, header.level, header.colour_level));
  const auto& root = header.root_path[static_cast<std::size_t>(state_->written)];
  state_->media.write(0, quantise(image, header.box, root));
  const cv::Mat colours = colour_plane(image);
  state_->media.write(1, std::span(&colours, 1));
  const cv::Mat coverage(image.colour_side(), image.colour_side(), CV_8UC1,
                         const_cast<std::uint8_t*>(image.coverage.data()));  // cv::Mat has no view of const pixels
  state_->media.write(2, std::span(&coverage, 1));
  ++state_->written;
}

void GeometryVideoWriter::finish() {
  if (state_->written != state_->header.frame_count())
    throw InvalidInput(fmt::format("the geometry video's header holds {} frames, {} were written",
                                   state_->header.frame_count(), state_->written));
  state_->media.finish();
}

void write_geometry_video(const std::filesystem::path& file, std::span<const GeometryImage> images, double fps) {
  GeometryVideoHeader header;
  header.fps = fps;
  for (const GeometryImage& image : images) add_frame(header, image);
  GeometryVideoWriter writer(file, header);
  for (const GeometryImage& image : images) writer.write(image);
  writer.finish();
}

}  // namespace rotunda::recon
