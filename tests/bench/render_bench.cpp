// Frames a second of the geometry-image renderer: the 257 lattice (131k triangles) with colours of 513, a body's size
// in the picture, every frame uploaded anew, one frame of lag; CPU time beside wall time. Then what a frame of a
// geometry video costs to write and to read.
//   render_bench [seconds a line]
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "playback/display/headless.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "recon/video/geometry_video.h"
#include "tests/unit/round_geometry_image.h"

namespace {

using namespace rotunda;

double cpu_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Runs the work for the time given and prints its line; the first runs (shader compilation, page faults) are not timed.
template <class Work>
void measure(const std::string& name, double seconds, Work&& work) {
  for (int i = 0; i < 5; ++i) work();
  const double wall = wall_seconds(), cpu = cpu_seconds();
  int runs = 0;
  do {
    work();
    ++runs;
  } while (wall_seconds() - wall < seconds);
  const double wall_each = (wall_seconds() - wall) / runs, cpu_each = (cpu_seconds() - cpu) / runs;
  fmt::print("{:44} {:7.1f} /s {:7.2f} ms wall {:7.2f} ms CPU\n", name, 1.0 / wall_each, 1e3 * wall_each,
             1e3 * cpu_each);
}

std::vector<recon::GeometryImage> bodies() {
  std::vector<recon::GeometryImage> images;
  for (int i = 0; i < 4; ++i)
    images.push_back(test::round_geometry_image({.level = 8,
                                                 .colour_level = 9,
                                                 .centre = {0.0F, 0.0F, 0.9F},
                                                 .radii = {0.3F + 0.01F * static_cast<float>(i), 0.25F, 0.9F}}));
  return images;
}

void draw_frames(const std::vector<recon::GeometryImage>& images, int width, int height, int level,
                 const playback::DrawOptions& options, double seconds) {
  const playback::RenderTarget target(width, height);
  playback::GeometryImageRenderer renderer;
  playback::FrameFence fence;
  playback::Orbit orbit{.target = {0.0, 0.0, 0.9}, .distance = 3.4};
  std::size_t frame = 0;
  const char* shading = options.shading == playback::Shading::grey ? " grey" : "";
  measure(fmt::format("draw level {} at {} x {}{}{}", level, width, height, shading, options.cull ? "" : " both sides"),
          seconds, [&] {
            renderer.upload(images[frame++ % images.size()]);
            orbit.turn(0.02, 0.0);
            target.bind();
            playback::clear(std::nullopt);
            renderer.draw(orbit.viewpoint(width, height), options, level);
            fence.frame_drawn();
          });
}

void video_frames(const std::vector<recon::GeometryImage>& images, double seconds) {
  const auto file = std::filesystem::temp_directory_path() / fmt::format("render_bench_{}.mkv", ::getpid());
  measure("write a geometry video of 4 frames", seconds, [&] { recon::write_geometry_video(file, images); });
  fmt::print("{:44} {:7.0f} kB a frame\n", "its size",
             1e-3 * static_cast<double>(std::filesystem::file_size(file)) / 4);
  recon::GeometryVideoReader reader(file);
  int frame = 0;
  measure("read a frame in sequence", seconds, [&] { static_cast<void>(reader.read(frame++ % 4)); });
  std::filesystem::remove(file);
}

}  // namespace

int main(int argc, char** argv) {
  playback::keep_scene_memory();
  const double seconds = argc > 1 ? std::atof(argv[1]) : 2.0;
  const playback::HeadlessDisplay display;
  const auto images = bodies();
  draw_frames(images, 1280, 720, 8, {}, seconds);
  draw_frames(images, 1280, 720, 8, {.cull = false}, seconds);
  draw_frames(images, 1280, 720, 8, {.shading = playback::Shading::grey}, seconds);
  draw_frames(images, 1280, 720, 7, {}, seconds);
  draw_frames(images, 720, 576, 8, {}, seconds);
  draw_frames(images, 1920, 1080, 8, {}, seconds);
  video_frames(images, seconds);
}
