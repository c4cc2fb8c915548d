#include "recon/video/paper_video.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

#include "config/errors.h"
#include "recon/video/lattice_normals.h"
#include "recon/video/media_file.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace {

constexpr double kLevelsPerMetre = 100.0;  // 1 cm
constexpr int kRoot = 128;                 // the level that means the root itself: 1 to 255 lie evenly about it

// Uncompressed: what every reader of AVI since the paper's day opens.
std::vector<VideoStream> paper_streams(int level) {
  const int side = 1 << level;
  return {{.title = "position", .codec = "rawvideo", .pixel_format = "bgr24", .width = side, .height = side},
          {.title = "colour", .codec = "rawvideo", .pixel_format = "bgr24", .width = side, .height = side}};
}

std::uint8_t level_of(double metres) {
  return static_cast<std::uint8_t>(std::clamp(std::round(metres * kLevelsPerMetre) + kRoot, 1.0, 255.0));
}

cv::Mat position_levels(const GeometryImage& image, const Eigen::Vector3d& root) {
  const int side = image.side();
  cv::Mat levels = cv::Mat::zeros(side - 1, side - 1, CV_8UC3);
  for (int row = 1; row < side - 1; ++row)
    for (int column = 1; column < side - 1; ++column) {
      const Eigen::Vector3d p = image.positions[static_cast<std::size_t>(row * side + column)].cast<double>() - root;
      levels.at<cv::Vec3b>(row - 1, column - 1) = {level_of(p.z()), level_of(p.y()), level_of(p.x())};  // bgr
    }
  return levels;
}

cv::Mat colour_levels(const GeometryImage& image) {
  const int side = image.side(), stride = 1 << (image.colour_level - image.level);
  cv::Mat levels = cv::Mat::zeros(side - 1, side - 1, CV_8UC3);
  for (int row = 1; row < side - 1; ++row)
    for (int column = 1; column < side - 1; ++column) {
      const Colour& c = image.colours[static_cast<std::size_t>(row * stride * image.colour_side() + column * stride)];
      levels.at<cv::Vec3b>(row - 1, column - 1) = {c[2], c[1], c[0]};  // bgr
    }
  return levels;
}

// The lattice with its border, from the picture that lacks it: a border sample is the mean of its inner neighbour and
// its copy's; the corners, one point, the mean of the four inner corners.
template <class Sample>
std::vector<Sample> closed(const cv::Mat& inner, int side, Sample (*sample_of)(const cv::Vec3f&)) {
  const int last = side - 1;
  const auto at = [&](int row, int column) {
    const auto v = inner.at<cv::Vec3b>(std::clamp(row, 1, last - 1) - 1, std::clamp(column, 1, last - 1) - 1);
    return cv::Vec3f(v);
  };
  const auto corners = 0.25F * (at(0, 0) + at(0, last) + at(last, 0) + at(last, last));
  std::vector<Sample> samples;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const bool on_row = row == 0 || row == last, on_column = column == 0 || column == last;
      cv::Vec3f value = at(row, column);
      if (on_row && on_column)
        value = corners;
      else if (on_row)
        value = 0.5F * (value + at(row, last - column));
      else if (on_column)
        value = 0.5F * (value + at(last - row, column));
      samples.push_back(sample_of(value));
    }
  return samples;
}

Eigen::Vector3f position_of(const cv::Vec3f& bgr) {
  return (Eigen::Vector3f(bgr[2], bgr[1], bgr[0]).array() - static_cast<float>(kRoot)) /
         static_cast<float>(kLevelsPerMetre);
}

Colour colour_of(const cv::Vec3f& bgr) {
  return {cv::saturate_cast<std::uint8_t>(bgr[2]), cv::saturate_cast<std::uint8_t>(bgr[1]),
          cv::saturate_cast<std::uint8_t>(bgr[0])};
}

GeometryImage image_of(const cv::Mat& positions, const cv::Mat& colours, int level, const Eigen::Vector3d& root) {
  GeometryImage image;
  image.level = image.colour_level = level;
  image.positions = closed(positions, image.side(), position_of);
  for (Eigen::Vector3f& position : image.positions) position += root.cast<float>();
  image.normals = lattice_normals(image.positions, image.level);
  image.colours = closed(colours, image.side(), colour_of);
  image.coverage.assign(image.colours.size(), 255);
  return image;
}

GeometryVideoHeader read_header(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::system_error(errno, std::generic_category(), "reading " + file.string());
  try {
    return header_from_json({std::istreambuf_iterator<char>(in), {}});
  } catch (const CorruptData& error) {
    throw CorruptData(file, 0, error.what());
  }
}

}  // namespace

struct PaperVideoWriter::State {
  std::filesystem::path json;
  GeometryVideoHeader header;
  MediaWriter media;
  int written = 0;
};

PaperVideoWriter::PaperVideoWriter(const std::filesystem::path& avi, const std::filesystem::path& json,
                                   const GeometryVideoHeader& header) {
  static_cast<void>(header_from_json(to_json(header)));  // what we write, we can read
  const MediaFileOptions options{.container = "avi",
                                 .fps = header.fps,
                                 .streams = paper_streams(header.level),
                                 .attachments = {},
                                 .container_options = {}};
  state_.reset(new State{json, header, {avi, options}, 0});
}

PaperVideoWriter::~PaperVideoWriter() = default;

void PaperVideoWriter::write(const GeometryImage& image) {
  if (state_->written >= state_->header.frame_count() || image.level != state_->header.level)
    throw InvalidInput(fmt::format("frame {} of the paper video does not fit its header", state_->written));
  const cv::Mat positions = position_levels(image, state_->header.root_path[static_cast<std::size_t>(state_->written)]);
  const cv::Mat colours = colour_levels(image);
  state_->media.write(0, std::span(&positions, 1));
  state_->media.write(1, std::span(&colours, 1));
  ++state_->written;
}

void PaperVideoWriter::finish() {
  if (state_->written != state_->header.frame_count())
    throw InvalidInput(fmt::format("the paper video's header holds {} frames, {} were written",
                                   state_->header.frame_count(), state_->written));
  state_->media.finish();
  write_text(state_->json, to_json(state_->header));
}

void write_paper_video(const std::filesystem::path& avi, const std::filesystem::path& json,
                       std::span<const GeometryImage> images, double fps) {
  GeometryVideoHeader header;
  header.fps = fps;
  for (const GeometryImage& image : images) add_frame(header, image);
  PaperVideoWriter writer(avi, json, header);
  for (const GeometryImage& image : images) writer.write(image);
  writer.finish();
}

GeometryImage as_paper_stores(const GeometryImage& image, const Eigen::Vector3d& root) {
  return image_of(position_levels(image, root), colour_levels(image), image.level, root);
}

struct PaperVideoReader::State {
  GeometryVideoHeader header;
  MediaReader media;
};

PaperVideoReader::PaperVideoReader(const std::filesystem::path& avi, const std::filesystem::path& json) {
  state_.reset(new State{read_header(json), MediaReader(avi)});
  state_->media.expect(paper_streams(state_->header.level), state_->header.fps);
}

PaperVideoReader::~PaperVideoReader() = default;

const GeometryVideoHeader& PaperVideoReader::header() const {
  return state_->header;
}

GeometryImage PaperVideoReader::read(int frame) {
  if (frame < 0 || frame >= state_->header.frame_count())
    throw InvalidInput(
        fmt::format("there is no frame {}; the paper video holds {}", frame, state_->header.frame_count()));
  const auto pictures = state_->media.read(frame);
  return image_of(pictures[0][0], pictures[1][0], state_->header.level,
                  state_->header.root_path[static_cast<std::size_t>(frame)]);
}

}  // namespace rotunda::recon
