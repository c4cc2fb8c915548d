#include "recon/frame_store.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "capture/picture.h"
#include "config/errors.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/lattice_normals.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  if (!(std::ofstream(file) << text))
    throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write " + file.string());
}

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

FrameStore::FrameStore(fs::path folder, const std::string& settings) : folder_(std::move(folder)) {
  const auto settings_file = folder_ / "settings.json";
  if (fs::exists(folder_) && read_text(settings_file) != settings) fs::remove_all(folder_);
  fs::create_directories(folder_);
  write_text(settings_file, settings);
}

fs::path FrameStore::path(std::size_t frame, const char* ending) const {
  return folder_ / fmt::format("frame{:06}{}", frame, ending);
}

bool FrameStore::finished(std::size_t frame) const {
  return fs::exists(path(frame, ".colour.png")) || fs::exists(path(frame, ".failed"));
}

std::optional<std::string> FrameStore::failure(std::size_t frame) const {
  const auto file = path(frame, ".failed");
  if (!fs::exists(file)) return std::nullopt;
  return read_text(file);
}

void FrameStore::save(std::size_t frame, const MappedSurface& surface, const GeometryImage& image) const {
  write_ply(path(frame, ".ply"), surface.mesh);
  auto directions = surface.map.points;
  write_tiff(path(frame, ".sphere.tiff"), cv::Mat(static_cast<int>(directions.size()), 3, CV_64FC1, directions.data()));
  auto positions = image.positions;
  write_tiff(path(frame, ".tiff"), cv::Mat(image.side(), image.side(), CV_32FC3, positions.data()));
  const auto unfinished = path(frame, ".unfinished.png");
  capture::write_png(unfinished, with_alpha(image));
  fs::rename(unfinished, path(frame, ".colour.png"));
}

void FrameStore::save_report(std::size_t frame, const std::string& json) const {
  write_text(path(frame, ".json"), json + "\n");
}

void FrameStore::save_failure(std::size_t frame, const std::string& reason) const {
  write_text(path(frame, ".failed"), reason);
}

MappedSurface FrameStore::surface(std::size_t frame) const {
  MappedSurface surface{.mesh = read_ply(path(frame, ".ply")), .map = {}};
  const auto directions = read_whole(path(frame, ".sphere.tiff"), CV_64FC1);
  if (directions.cols != 3 || directions.rows != static_cast<int>(surface.mesh.positions.size()))
    throw CorruptData(path(frame, ".sphere.tiff").string() + ": is not the sphere map of the mesh beside it");
  const auto* first = directions.ptr<Eigen::Vector3d>();
  surface.map.points.assign(first, first + directions.rows);
  return surface;
}

GeometryImage FrameStore::image(std::size_t frame) const {
  const auto positions = read_whole(path(frame, ".tiff"), CV_32FC3);
  cv::Mat colours = read_whole(path(frame, ".colour.png"), CV_8UC4);
  cv::cvtColor(colours, colours, cv::COLOR_BGRA2RGBA);
  GeometryImage image;
  image.level = level_of(positions, path(frame, ".tiff"));
  image.colour_level = level_of(colours, path(frame, ".colour.png"));
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

}  // namespace rotunda::recon
