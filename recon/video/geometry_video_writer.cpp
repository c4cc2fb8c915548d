#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/video/geometry_picture.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"
#include "recon/video/media_file.h"
#include "recon/video/position_coding.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace {

MediaFileOptions media_options(const GeometryVideoHeader& header, const std::string& mean_png, bool avi) {
  MediaFileOptions options{.container = avi ? "avi" : "matroska",
                           .fps = header.fps,
                           .streams = geometry_video_streams(header),
                           .attachments = {}};
  if (avi) return options;
  options.attachments.push_back({"geometry.json", kHeaderMimeType, to_json(header)});
  if (!mean_png.empty()) options.attachments.push_back({"mean.png", kMeanMimeType, mean_png});
  return options;
}

GeometryVideoHeader with_differences(GeometryVideoHeader header, const MeanSurface& mean) {
  header.from_mean = !mean.empty();
  if (header.from_mean && header.profile == VideoProfile::float32)
    throw InvalidInput("a geometry video of profile float holds positions themselves, no differences from a mean");
  if (!header.from_mean && header.profile == VideoProfile::stream)
    throw InvalidInput("a geometry video to be streamed needs the mean of its positions");
  if (header.from_mean) header.difference_box = difference_box(header, mean);
  header.version = version_of(header);
  return header;
}

std::vector<cv::Mat> gbr_planes(const GeometryImage& image) {
  std::vector<cv::Mat> planes;
  cv::split(colour_picture(image), planes);
  return {planes[1], planes[2], planes[0]};
}

cv::Mat colour_plane(const GeometryImage& image) {
  cv::Mat plane(image.colour_side(), image.colour_side(), CV_8UC4);
  auto* bgr0 = plane.ptr<cv::Vec4b>();
  for (const Colour& c : image.colours) *bgr0++ = {c[2], c[1], c[0], 0};
  return plane;
}

// Full range, BT.601; OpenCV puts red before blue.
std::vector<cv::Mat> ycbcr_planes(const GeometryImage& image) {
  const cv::Mat rgb = colour_picture(image);
  cv::Mat mixed;
  cv::cvtColor(rgb, mixed, cv::COLOR_RGB2YCrCb);
  std::vector<cv::Mat> planes;
  cv::split(mixed, planes);
  std::swap(planes[1], planes[2]);
  return planes;
}

}  // namespace

struct GeometryVideoWriter::State {
  std::filesystem::path file;
  std::string mean_png;
  GeometryVideoHeader header;
  PositionCoding positions;
  MediaWriter media;
  int written = 0;
};

GeometryVideoWriter::GeometryVideoWriter(const std::filesystem::path& file, const GeometryVideoHeader& given,
                                         const MeanSurface& mean) {
  const auto header = with_differences(given, mean);
  constexpr int kCoarsestStream = 6;  // a HEVC picture holds at least one block of 64 x 64
  if (header.profile == VideoProfile::stream && header.level < kCoarsestStream)
    throw InvalidInput(
        fmt::format("a geometry video to be streamed has at least level {}, not {}", kCoarsestStream, header.level));
  if (header.profile == VideoProfile::stream && is_avi(file))
    throw InvalidInput(file.string() + ": AVI keeps the profiles master, float and paper; a stream is an .mkv");
  static_cast<void>(header_from_json(to_json(header)));  // what we write, we can read
  const auto mean_png = header.from_mean ? encode_mean(header, mean.positions()) : std::string();
  state_.reset(new State{file,
                         mean_png,
                         header,
                         PositionCoding(header, mean_png),
                         {file, media_options(header, mean_png, is_avi(file))},
                         0});
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
  const auto positions = state_->positions.encode(image.positions, root);
  state_->media.write(0, positions[0]);
  if (header.profile == VideoProfile::stream) {
    state_->media.write(1, ycbcr_planes(image));
  } else if (header.version >= kColourChecksumVersion) {
    if (checksum_of(image.colours) != header.colour_checksums.at(static_cast<std::size_t>(state_->written)))
      throw InvalidInput(
          fmt::format("frame {} of the geometry video has other colours than the header was told of", state_->written));
    state_->media.write(1, gbr_planes(image));
  } else {
    const cv::Mat colours = colour_plane(image);
    state_->media.write(1, std::span(&colours, 1));
  }
  const cv::Mat coverage(image.colour_side(), image.colour_side(), CV_8UC1,
                         const_cast<std::uint8_t*>(image.coverage.data()));  // cv::Mat has no view of const pixels
  state_->media.write(2, std::span(&coverage, 1));
  if (positions.size() > 1) state_->media.write(3, positions[1]);
  ++state_->written;
}

void GeometryVideoWriter::finish() {
  if (state_->written != state_->header.frame_count())
    throw InvalidInput(fmt::format("the geometry video's header holds {} frames, {} were written",
                                   state_->header.frame_count(), state_->written));
  if (is_avi(state_->file)) {
    if (!state_->mean_png.empty()) write_text(beside(state_->file, ".mean.png"), state_->mean_png);
    write_text(beside(state_->file, ".json"), to_json(state_->header));
  }
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
