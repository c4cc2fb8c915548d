#include "playback/render/animation_film.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/render/film_writer.h"
#include "playback/render/mesh_renderer.h"
#include "playback/render/orbit_film.h"

namespace rotunda::playback {
namespace {

constexpr int kSupersample = 2;

// Draws one frame of the animation after another.
class Picture {
 public:
  Picture(recon::ScanAnimation& animation, std::span<const recon::HandlePose> poses, double azimuth, int width,
          int height)
      : animation_(animation),
        poses_(poses),
        width_(kSupersample * width),
        height_(kSupersample * height),
        target_(width_, height_),
        posed_(animation.rest()) {
    // Arms may be raised or spread: room for them about the body.
    Eigen::AlignedBox3d box;
    for (const auto& p : posed_.positions) box.extend(p.cast<double>());
    const double reach = 0.62 * box.sizes().z();
    orbit_ = orbit_around(
        {Eigen::Vector3d(-0.5 * reach, -0.5 * reach, 0.0), Eigen::Vector3d(0.5 * reach, 0.5 * reach, 2.0 * reach)},
        Orbit{}.field_of_view, static_cast<double>(width) / height);
    orbit_.azimuth = azimuth;
    orbit_.zoom(1.35);  // the box's corners are empty
    eye_height_ = 0.5 * box.sizes().z();
  }

  cv::Mat draw(std::size_t frame) {
    const auto pose = poses_.subspan(frame * recon::kBodySegments, recon::kBodySegments);
    animation_.deform(pose, posed_.positions);
    recon::compute_normals(posed_);
    renderer_.upload(posed_);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const auto& p : posed_.positions) sum += p;
    const Eigen::Vector3d middle = sum.cast<double>() / static_cast<double>(posed_.positions.size());
    orbit_.target = {middle.x(), middle.y(), eye_height_};
    target_.bind();
    clear(std::nullopt);
    const auto shading = posed_.colours.empty() ? Shading::grey : Shading::colour;
    renderer_.draw(orbit_.viewpoint(width_, height_), {.shading = shading, .cull = false});
    return reduce(target_.read_rgba(), kSupersample);
  }

 private:
  recon::ScanAnimation& animation_;
  std::span<const recon::HandlePose> poses_;
  int width_, height_;
  RenderTarget target_;
  MeshRenderer renderer_;
  recon::TriangleMesh posed_;
  Orbit orbit_;
  double eye_height_ = 1.0;
};

constexpr recon::Colour kBackground{236, 238, 242};

void check_stop(const std::stop_token& stop) {
  if (stop.stop_requested()) throw std::system_error(std::make_error_code(std::errc::operation_canceled), "stopped");
}

void write_film(recon::ScanAnimation& animation, std::span<const recon::HandlePose> poses,
                const AnimationFilmOptions& options) {
  const std::size_t frames = poses.size() / recon::kBodySegments;
  Picture picture(animation, poses, options.azimuth, options.width, options.height);
  const auto film = make_film_writer(
      options.output,
      {.width = options.width, .height = options.height, .fps = 1.0 / options.frame_time, .background = kBackground});
  for (std::size_t f = 0; f < frames; ++f) {
    check_stop(options.stop);
    film->write(picture.draw(f));
    if (options.progress) options.progress(f + 1, frames);
  }
  film->finish();
}

void write_sheet(recon::ScanAnimation& animation, std::span<const recon::HandlePose> poses,
                 const AnimationFilmOptions& options) {
  const std::size_t frames = poses.size() / recon::kBodySegments;
  const auto tiles = static_cast<std::size_t>(options.columns * options.rows);
  const int width = options.height / 2, height = options.height / 2;
  Picture picture(animation, poses, options.azimuth, width, height);
  cv::Mat sheet(options.rows * height, options.columns * width, CV_8UC3);
  for (std::size_t i = 0; i < tiles; ++i) {
    check_stop(options.stop);
    const std::size_t frame = tiles > 1 ? i * (frames - 1) / (tiles - 1) : 0;
    const auto column = static_cast<int>(i) % options.columns, row = static_cast<int>(i) / options.columns;
    over_background(picture.draw(frame), kBackground)
        .copyTo(sheet(cv::Rect(column * width, row * height, width, height)));
    if (options.progress) options.progress(i + 1, tiles);
  }
  cv::cvtColor(sheet, sheet, cv::COLOR_RGB2BGR);
  if (!cv::imwrite(options.output.string(), sheet))
    throw std::system_error(std::make_error_code(std::errc::io_error), options.output.string() + ": cannot be written");
}

}  // namespace

void write_animation_film(recon::ScanAnimation& animation, std::span<const recon::HandlePose> poses,
                          const AnimationFilmOptions& options) {
  if (poses.empty()) throw InvalidInput("the motion to film has no frame");
  const HeadlessDisplay display;
  if (options.output.extension() == ".png")
    write_sheet(animation, poses, options);
  else
    write_film(animation, poses, options);
}

}  // namespace rotunda::playback
