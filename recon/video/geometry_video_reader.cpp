#include <fmt/format.h>

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"
#include "recon/video/lattice_normals.h"
#include "recon/video/media_file.h"
#include "recon/video/position_coding.h"

namespace rotunda::recon {
namespace {

GeometryVideoHeader read_header(const MediaReader& media, const std::filesystem::path& file) {
  const std::string json = media.attachment(kHeaderMimeType);
  if (json.empty()) throw CorruptData(file, 0, "there is no geometry video header in it");
  try {
    return header_from_json(json);
  } catch (const CorruptData& error) {
    throw CorruptData(file, 0, error.what());
  }
}

// Of the planes Y, Cb, Cr.
std::vector<Colour> colours_of_ycbcr(const std::vector<cv::Mat>& planes) {
  cv::Mat mixed, rgb;
  cv::merge(std::vector<cv::Mat>{planes[0], planes[2], planes[1]}, mixed);
  cv::cvtColor(mixed, rgb, cv::COLOR_YCrCb2RGB);
  std::vector<Colour> colours(rgb.total());
  std::memcpy(colours.data(), rgb.data, colours.size() * sizeof(Colour));
  return colours;
}

std::vector<Colour> colours_of(const cv::Mat& bgr0) {
  std::vector<Colour> colours(bgr0.total());
  const auto* pixel = bgr0.ptr<cv::Vec4b>();
  for (Colour& colour : colours) {
    colour = {(*pixel)[2], (*pixel)[1], (*pixel)[0]};
    ++pixel;
  }
  return colours;
}

PositionCoding read_coding(const MediaReader& media, const GeometryVideoHeader& header,
                           const std::filesystem::path& file) {
  try {
    return PositionCoding(header, media.attachment(kMeanMimeType));
  } catch (const CorruptData& error) {
    throw CorruptData(file, 0, error.what());
  }
}

}  // namespace

struct GeometryVideoReader::State {
  MediaReader media;
  GeometryVideoHeader header;
  PositionCoding positions;

  explicit State(const std::filesystem::path& file)
      : media(file), header(read_header(media, file)), positions(read_coding(media, header, file)) {
    media.expect(geometry_video_streams(header), header.fps);
  }

  GeometryImage read(int frame, int level, bool in_place) {
    if (frame < 0 || frame >= header.frame_count())
      throw InvalidInput(fmt::format("there is no frame {}; the geometry video holds {}", frame, header.frame_count()));
    if (level < 1 || level > header.level)
      throw InvalidInput(fmt::format("there is no level {}; the geometry video holds 1 to {}", level, header.level));
    const auto pictures = media.read(frame);
    const Eigen::Vector3d root = in_place ? Eigen::Vector3d::Zero() : header.root_path[static_cast<std::size_t>(frame)];
    GeometryImage image;
    image.level = level;
    image.positions = positions.decode(pictures, root, 1 << (header.level - level));
    image.normals = lattice_normals(image.positions, level);
    image.colour_level = header.colour_level;
    image.colours = header.profile == VideoProfile::stream ? colours_of_ycbcr(pictures[1]) : colours_of(pictures[1][0]);
    image.coverage.assign(pictures[2][0].datastart, pictures[2][0].dataend);
    return image;
  }
};

GeometryVideoReader::GeometryVideoReader(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {}
GeometryVideoReader::~GeometryVideoReader() = default;
GeometryVideoReader::GeometryVideoReader(GeometryVideoReader&&) noexcept = default;
GeometryVideoReader& GeometryVideoReader::operator=(GeometryVideoReader&&) noexcept = default;

const GeometryVideoHeader& GeometryVideoReader::header() const {
  return state_->header;
}
int GeometryVideoReader::frame_count() const {
  return state_->header.frame_count();
}

GeometryImage GeometryVideoReader::read(int frame) {
  return state_->read(frame, state_->header.level, false);
}
GeometryImage GeometryVideoReader::read(int frame, int level) {
  return state_->read(frame, level, false);
}
GeometryImage GeometryVideoReader::read_in_place(int frame, int level) {
  return state_->read(frame, level, true);
}

}  // namespace rotunda::recon
