#include <fmt/format.h>

#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"
#include "recon/video/lattice_normals.h"
#include "recon/video/media_file.h"

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

std::vector<Eigen::Vector3f> dequantise(const std::vector<cv::Mat>& planes, const Eigen::AlignedBox3d& box,
                                        const Eigen::Vector3d& root, int stride) {
  const Eigen::Vector3d low = box.min() + root, metres_per_step = box.sizes() / 65535.0;
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(planes[0].total() / static_cast<std::size_t>(stride * stride));
  for (int row = 0; row < planes[0].rows; row += stride) {
    const auto *x = planes[0].ptr<std::uint16_t>(row), *y = planes[1].ptr<std::uint16_t>(row),
               *z = planes[2].ptr<std::uint16_t>(row);
    for (int column = 0; column < planes[0].cols; column += stride)
      positions.emplace_back(
          (low + metres_per_step.cwiseProduct(Eigen::Vector3d(x[column], y[column], z[column]))).cast<float>());
  }
  return positions;
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

}  // namespace

struct GeometryVideoReader::State {
  MediaReader media;
  GeometryVideoHeader header;

  explicit State(const std::filesystem::path& file) : media(file), header(read_header(media, file)) {
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
    image.positions = dequantise(pictures[0], header.box, root, 1 << (header.level - level));
    image.normals = lattice_normals(image.positions, level);
    image.colour_level = header.colour_level;
    image.colours = colours_of(pictures[1][0]);
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
