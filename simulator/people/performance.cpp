#include "simulator/people/performance.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/errors.h"
#include "simulator/people/bvh_motion.h"
#include "simulator/people/fingerprint.h"
#include "simulator/people/gltf_performance.h"
#include "simulator/people/synthetic_performance.h"

namespace rotunda::simulator {

namespace {

bool is_gltf(const std::string& person) {
  return person.ends_with(".glb") || person.ends_with(".gltf");
}

std::unique_ptr<Performance> gltf_performance(const PerformanceOptions& options) {
  if (options.motion)
    throw InvalidInput(
        fmt::format("{} moves by its own clips: a BVH file drives the simulator's own people", options.person));
  auto performance = std::make_unique<GltfPerformance>(options.person, options.act);
  for (const auto& note : performance->notes()) spdlog::info("{}: {}", options.person, note);
  return performance;
}

Motion motion_from_file(const std::filesystem::path& file, const Skeleton& skeleton) {
  auto imported = import_motion(recon::read_bvh(file), file.string(), skeleton);
  for (const auto& note : imported.notes) spdlog::info("{}: {}", file.string(), note);
  return std::move(imported.motion);
}

}  // namespace

std::unique_ptr<Performance> make_performance(const PerformanceOptions& options) {
  if (is_gltf(options.person)) return gltf_performance(options);
  auto description = describe_person(options.person);
  description.coarseness = options.coarseness;
  if (options.texels_per_edge) description.texels_per_edge = *options.texels_per_edge;
  return make_performance(make_person(description), options);
}

std::unique_ptr<Performance> make_performance(Person person, const PerformanceOptions& options) {
  auto motion = options.motion
                    ? motion_from_file(*options.motion, person.skeleton)
                    : motion_of(options.act, person.skeleton, {.travel = options.travel, .seed = options.seed});
  const bool has_board = !options.motion && options.act == "board";
  auto performance = std::make_unique<SyntheticPerformance>(std::move(person), std::move(motion));
  if (has_board) performance->carry_board();
  return performance;
}

namespace {

template <class T>
void add_all(Fingerprint& print, const std::vector<T>& values) {
  print.add(values.size());
  print.add_bytes(values.data(), values.size() * sizeof(T));
}

}  // namespace

void add_to(Fingerprint& print, const std::vector<Figure>& figures) {
  for (const auto& figure : figures) {
    add_all(print, figure.bind.positions);
    add_all(print, figure.bind.triangles);
    add_all(print, figure.openness);
    add_all(print, figure.material);
    add_all(print, figure.texture.corners);
    const cv::Mat& picture = figure.texture.picture;
    for (int row = 0; row < picture.rows; ++row)
      print.add_bytes(picture.ptr(row), static_cast<std::size_t>(picture.cols) * picture.elemSize());
  }
}

int act_frame_at(capture::Timestamp exposure_start, int frames) {
  constexpr auto kStepNs = static_cast<std::int64_t>(kActStep * 1e9);
  const std::int64_t step = (exposure_start.time_since_epoch().count() + kStepNs / 2) / kStepNs;
  return static_cast<int>(step % frames);
}

}  // namespace rotunda::simulator
