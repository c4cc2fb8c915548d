// How fast the simulated studio renders: a walk before ten cameras, everything included that a camera sends (surfaces,
// light, figures, lens, sensor, mosaic), wall and CPU; then its stages alone, and the bare copying of the backdrops.
// usage: studio_bench [MOMENTS [WIDTH HEIGHT]]
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>

#include "simulator/people/performance.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/light.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"

namespace {

using namespace rotunda;

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Milliseconds a camera image.
template <class Work>
void measure(const char* name, int images, const Work& work) {
  work();  // warm: shaders are compiled, memory is there
  const double wall = seconds_of(CLOCK_MONOTONIC), cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  work();
  const double wall_ms = 1e3 * (seconds_of(CLOCK_MONOTONIC) - wall) / images;
  const double cpu_ms = 1e3 * (seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu) / images;
  fmt::print("{:24} wall {:7.2f} ms  {:6.1f} images/s  CPU {:7.2f} ms\n", name, wall_ms, 1e3 / wall_ms, cpu_ms);
}

}  // namespace

int main(int argc, char** argv) {
  const int moments = argc > 1 ? std::atoi(argv[1]) : 5;
  simulator::LayoutOptions layout;
  if (argc > 3) layout.width = std::atoi(argv[2]), layout.height = std::atoi(argv[3]);
  const auto cameras = simulator::camera_layout(layout);
  const auto walk = simulator::make_performance({.person = "alex", .act = "walk"});
  simulator::SceneRenderer studio(*walk, cameras);
  const int images = moments * static_cast<int>(cameras.size());
  fmt::print("{} cameras of {} x {}, {} moments, {} triangles\n", cameras.size(), layout.width, layout.height, moments,
             walk->figures().front().bind.triangles.size());

  measure("whole camera image", images, [&] {
    for (int i = 0; i < moments; ++i)
      for (const auto& picture : studio.pictures(0.04 * i, static_cast<std::uint64_t>(i)))
        simulator::encode_pixels(picture.deep, capture::PixelFormat::bayer_rg8);
  });
  const auto surfaces = walk->surfaces_at(0.2);
  measure("surfaces", images, [&] {
    for (int i = 0; i < 3 * moments; ++i) walk->surfaces_at(0.04 * i);
  });
  measure("shadows", images, [&] {
    for (int i = 0; i < moments; ++i) simulator::contact_shadow(surfaces, simulator::ShadowMaps(surfaces));
  });
  simulator::LitFigures lit{walk->surfaces_at(0.1975), walk->surfaces_at(0.2025), {}};
  auto& light = lit.light.emplace_back();
  for (std::size_t v = 0; v < surfaces.front().positions.size(); ++v)
    light.push_back(simulator::arriving_light({surfaces.front().positions[v], surfaces.front().normals[v], 1.0F},
                                              walk->figures().front().material[v], {}));
  const simulator::FigureRenderer renderer(walk->figures());
  measure("figures", images, [&] {
    for (int i = 0; i < images; ++i)
      renderer.draw(cameras[static_cast<std::size_t>(i) % cameras.size()], lit,
                    simulator::default_supersampling(layout.width));
  });
  const auto backdrop = simulator::make_backdrop(cameras.front());
  const simulator::Sensor sensor(backdrop.linear.size(), 0, {});
  measure("sensor", images, [&] {
    for (int i = 0; i < images; ++i) simulator::to_8bit(sensor.expose(backdrop.linear, static_cast<std::uint64_t>(i)));
  });
  measure("baseline: bare copy", images, [&] {
    for (int i = 0; i < images; ++i) cv::Mat copy = backdrop.linear.clone();
  });
  return 0;
}
