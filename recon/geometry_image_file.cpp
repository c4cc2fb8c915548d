#include "recon/geometry_image_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "capture/picture.h"
#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/lattice_normals.h"

namespace rotunda::recon {

namespace fs = std::filesystem;

namespace {

void write_tiff(const fs::path& file, const cv::Mat& numbers) {
  if (!cv::imwrite(file.string(), numbers, {cv::IMWRITE_TIFF_COMPRESSION, 1}))
    throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write " + file.string());
}

cv::Mat with_alpha(const GeometryImage& image) {
  const int side = image.colour_side();
  cv::Mat picture(side, side, CV_8UC4);
  for (int i = 0; i < side * side; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto& c = image.colours[at];
    picture.ptr<cv::Vec4b>()[i] = {c[0], c[1], c[2], image.coverage[at]};
  }
  return picture;
}

int level_of(const cv::Mat& picture, const fs::path& file) {
  for (int level = kMinLatticeLevel; level <= kMaxLatticeLevel; ++level)
    if (picture.rows == lattice_side(level) && picture.cols == lattice_side(level)) return level;
  throw CorruptData(
      fmt::format("{}: {} x {} samples are no geometry image", file.string(), picture.cols, picture.rows));
}

cv::Mat read_whole(const fs::path& file, int type) {
  cv::Mat picture = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  if (picture.empty() || picture.type() != type)
    throw CorruptData(file.string() + ": is missing or damaged; delete the folder recon/frames and reconstruct again");
  return picture;
}

}  // namespace

void write_geometry_image(const fs::path& positions_file, const fs::path& colours_file, const GeometryImage& image) {
  auto positions = image.positions;
  write_tiff(positions_file, cv::Mat(image.side(), image.side(), CV_32FC3, positions.data()));
  capture::write_png(colours_file, with_alpha(image));
}

GeometryImage read_geometry_image(const fs::path& positions_file, const fs::path& colours_file) {
  const auto positions = read_whole(positions_file, CV_32FC3);
  cv::Mat colours = read_whole(colours_file, CV_8UC4);
  cv::cvtColor(colours, colours, cv::COLOR_BGRA2RGBA);
  GeometryImage image;
  image.level = level_of(positions, positions_file);
  image.colour_level = level_of(colours, colours_file);
  const auto* first = positions.ptr<Eigen::Vector3f>();
  image.positions.assign(first, first + positions.total());
  image.normals = lattice_normals(image.positions, image.level);
  for (std::size_t i = 0; i < colours.total(); ++i) {
    const auto& c = colours.ptr<cv::Vec4b>()[i];
    image.colours.push_back({c[0], c[1], c[2]});
    image.coverage.push_back(c[3]);
  }
  return image;
}

void write_directions(const fs::path& file, const std::vector<Eigen::Vector3d>& directions) {
  auto numbers = directions;
  write_tiff(file, cv::Mat(static_cast<int>(numbers.size()), 3, CV_64FC1, numbers.data()));
}

std::vector<Eigen::Vector3d> read_directions(const fs::path& file) {
  const auto numbers = read_whole(file, CV_64FC1);
  if (numbers.cols != 3) throw CorruptData(file.string() + ": holds no directions");
  const auto* first = numbers.ptr<Eigen::Vector3d>();
  return {first, first + numbers.rows};
}

}  // namespace rotunda::recon
