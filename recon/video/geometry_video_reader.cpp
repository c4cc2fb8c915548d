#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"
#include "recon/video/lattice_normals.h"
#include "recon/video/media_file.h"
#include "recon/video/position_coding.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kCoverageStream = 2;

std::string content_beside(const std::filesystem::path& file, const std::string& ending) {
  const auto name = beside(file, ending);
  std::ifstream in(name, std::ios::binary);
  if (!in) throw std::system_error(errno, std::generic_category(), "reading " + name.string());
  return {std::istreambuf_iterator<char>(in), {}};
}

GeometryVideoHeader read_header(const MediaReader& media, const std::filesystem::path& file) {
  const std::string json = is_avi(file) ? content_beside(file, ".json") : media.attachment(kHeaderMimeType);
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

std::vector<Colour> colours_of_gbr(const std::vector<cv::Mat>& planes) {
  std::vector<Colour> colours(planes[0].total());
  cv::Mat rgb(planes[0].size(), CV_8UC3, colours.data());
  cv::merge(std::vector<cv::Mat>{planes[2], planes[0], planes[1]}, rgb);
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
  const bool is_beside = is_avi(file) && header.from_mean;
  try {
    return PositionCoding(header, is_beside ? content_beside(file, ".mean.png") : media.attachment(kMeanMimeType));
  } catch (const CorruptData& error) {
    throw CorruptData(file, 0, error.what());
  }
}

}  // namespace

struct GeometryVideoReader::State {
  std::filesystem::path file;
  MediaReader media;
  GeometryVideoHeader header;
  PositionCoding positions;

  explicit State(const std::filesystem::path& name)
      : file(name), media(file), header(read_header(media, file)), positions(read_coding(media, header, file)) {
    media.expect(geometry_video_streams(header), header.fps);
  }

  std::vector<Colour> colours(const std::vector<cv::Mat>& planes, int frame) const {
    if (header.profile == VideoProfile::stream) return colours_of_ycbcr(planes);
    if (header.version < kColourChecksumVersion) return colours_of(planes[0]);
    auto colours = colours_of_gbr(planes);
    if (checksum_of(colours) != header.colour_checksums[static_cast<std::size_t>(frame)])
      throw CorruptData(file, 0, fmt::format("frame {}, stream colour is damaged (checksum)", frame));
    return colours;
  }

  GeometryImage read(int frame, const FrameReadOptions& options) {
    const int level = options.level > 0 ? options.level : header.level;
    if (frame < 0 || frame >= header.frame_count())
      throw InvalidInput(fmt::format("there is no frame {}; the geometry video holds {}", frame, header.frame_count()));
    if (options.level < 0 || level > header.level)
      throw InvalidInput(
          fmt::format("there is no level {}; the geometry video holds 1 to {}", options.level, header.level));
    const auto pictures = media.read(frame, options.drawn ? kCoverageStream : MediaReader::kNone);
    const Eigen::Vector3d root =
        options.in_place ? Eigen::Vector3d::Zero() : header.root_path[static_cast<std::size_t>(frame)];
    GeometryImage image;
    image.level = level;
    image.positions = positions.decode(pictures, root, 1 << (header.level - level));
    image.colour_level = header.colour_level;
    image.colours = colours(pictures[1], frame);
    if (options.drawn) return image;
    image.normals = lattice_normals(image.positions, level);
    image.coverage.assign(pictures[kCoverageStream][0].datastart, pictures[kCoverageStream][0].dataend);
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
  return state_->read(frame, {});
}
GeometryImage GeometryVideoReader::read(int frame, int level) {
  if (level < 1) throw InvalidInput(fmt::format("there is no level {} of a geometry video", level));
  return state_->read(frame, {.level = level});
}
GeometryImage GeometryVideoReader::read(int frame, const FrameReadOptions& options) {
  return state_->read(frame, options);
}
GeometryImage GeometryVideoReader::read_in_place(int frame, int level) {
  return state_->read(frame, {.level = level, .in_place = true});
}

void blend(GeometryImage& image, const GeometryImage& other, float share) {
  for (std::size_t i = 0; i < image.positions.size(); ++i)
    image.positions[i] += share * (other.positions[i] - image.positions[i]);
  if (!image.normals.empty()) image.normals = lattice_normals(image.positions, image.level);
  for (std::size_t i = 0; i < image.colours.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      image.colours[i][c] = static_cast<std::uint8_t>((1.0F - share) * static_cast<float>(image.colours[i][c]) +
                                                      share * static_cast<float>(other.colours[i][c]) + 0.5F);
  for (std::size_t i = 0; i < image.coverage.size(); ++i)
    image.coverage[i] = std::min(image.coverage[i], other.coverage[i]);
}

GeometryImage GeometryVideoReader::read_between(double at, int level) {
  constexpr double kOnFrame = 1e-6;  // of a frame: rates that divide each other meet their frames
  if (!(at >= -kOnFrame && at <= frame_count() - 1 + kOnFrame))
    throw InvalidInput(fmt::format("there is no frame {}; the geometry video holds {}", at, frame_count()));
  const double nearest = std::round(at);
  if (!header().aligned || std::abs(at - nearest) <= kOnFrame) return read(static_cast<int>(nearest), level);
  const int before = static_cast<int>(std::floor(at));
  auto image = read(before, level);
  blend(image, read(before + 1, level), static_cast<float>(at - before));
  return image;
}

}  // namespace rotunda::recon
