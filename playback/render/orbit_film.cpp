#include "playback/render/orbit_film.h"

#include <fmt/format.h>

#include <array>
#include <numbers>
#include <vector>

#include "config/errors.h"
#include "playback/performer_place.h"

namespace rotunda::playback {
namespace {

FrameRange range_of(const OrbitFilmOptions& options, int frames) {
  const FrameRange range{options.first_frame, options.last_frame < 0 ? frames : options.last_frame};
  if (range.first < 0 || range.last > frames || range.count() < 1)
    throw InvalidInput(
        fmt::format("frames {}:{} are not in what was recorded, which has 0:{}", range.first, range.last, frames));
  return range;
}

Orbit first_orbit(const OrbitFilmOptions& options, const Eigen::AlignedBox3d& box) {
  Orbit orbit = orbit_around(box, Orbit{}.field_of_view, static_cast<double>(options.width) / options.height);
  if (options.distance) orbit.distance = *options.distance;
  orbit.azimuth = options.azimuth;
  orbit.elevation = options.elevation;
  return orbit;
}

}  // namespace

int render_orbit(recon::GeometryVideoReader& video, const OrbitFilmOptions& options, FilmWriter& film) {
  const auto painter = stored_painter(video, options.draw);
  return render_orbit(performer_path(video.header()), {painter.get()}, options, film);
}

int render_orbit(const PerformerPath& path, const std::vector<FramePainter*>& painters, const OrbitFilmOptions& options,
                 FilmWriter& film) {
  const FrameRange range = range_of(options, path.frame_count());
  if (options.supersample < 1 || options.supersample > 4 || options.width < 1 || options.height < 1)
    throw InvalidInput("a film needs a size, and is drawn 1 to 4 times as large");
  const int all = options.pictures > 0 ? options.pictures : range.count();
  const int width = options.width * options.supersample, height = options.height * options.supersample;
  const RenderTarget target(width, height);
  Orbit orbit = first_orbit(options, path.box);
  int shown = -1;
  for (int picture = 0; picture < all; ++picture) {
    if (options.stop.stop_requested()) return picture;
    const int frame = range.first + picture % range.count();
    if (frame != shown)
      for (auto* painter : painters) painter->show(frame);
    shown = frame;
    orbit.target = performer_place(path, range, frame);
    std::vector<cv::Mat> tiles;
    for (auto* painter : painters) {
      target.bind();
      clear(options.background);
      painter->draw(orbit.viewpoint(width, height));
      tiles.push_back(reduce(target.read_rgba(), options.supersample));
    }
    cv::Mat row;
    cv::hconcat(tiles, row);
    film.write(row);
    orbit.turn(2.0 * std::numbers::pi * options.turns / all, 0.0);
    if (options.progress) options.progress(picture + 1, all);
  }
  film.finish();
  return all;
}

cv::Mat reduce(const cv::Mat& rgba, int factor) {
  if (factor == 1) return rgba;
  cv::Mat small(rgba.rows / factor, rgba.cols / factor, CV_8UC4);
  std::vector<std::array<int, 4>> sums(static_cast<std::size_t>(small.cols));  // colours weighted by their alpha
  for (int row = 0; row < small.rows; ++row) {
    sums.assign(sums.size(), {});
    for (int y = row * factor; y < (row + 1) * factor; ++y) {
      const std::uint8_t* pixel = rgba.ptr(y);
      for (auto& sum : sums)
        for (int x = 0; x < factor; ++x, pixel += 4) {
          for (std::size_t i = 0; i < 3; ++i) sum[i] += pixel[i] * pixel[3];
          sum[3] += pixel[3];
        }
    }
    std::uint8_t* pixel = small.ptr(row);
    for (const auto& sum : sums) {
      for (std::size_t i = 0; i < 3; ++i)
        *pixel++ = sum[3] > 0 ? static_cast<std::uint8_t>((sum[i] + sum[3] / 2) / sum[3]) : std::uint8_t{0};
      *pixel++ = static_cast<std::uint8_t>((sum[3] + factor * factor / 2) / (factor * factor));
    }
  }
  return small;
}

}  // namespace rotunda::playback
