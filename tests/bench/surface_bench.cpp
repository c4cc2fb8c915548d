// How long each step from silhouettes to a closed surface takes, how that grows with finer cells, and how far the
// surface lies from the body that cast them: ten 720 x 576 cameras, 10 mm cells.
//   surface_bench [BODY.ply] [--runs N]; without a body, a person of capsules
//   surface_bench --truth fitted|held-out|all [--studies N] [--keep DIR]: what each rung gains on rendered people
//   (surface_ladder.h) surface_bench --growth [--keep DIR]: time and memory of the whole surface by cell, pictures
//   matched (surface_growth.h) surface_bench --fit [--keep DIR]: how the law by rim distance was chosen
//   (rim_law_search.h)
// Silhouettes of a mesh are its triangles filled at eight times the size. Prints medians.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "config/exit_code.h"
#include "config/median.h"
#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/surface.h"
#include "recon/hull/visual_hull.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/studio/camera_layout.h"
#include "tests/bench/rim_law_search.h"
#include "tests/bench/surface_growth.h"
#include "tests/bench/surface_ladder.h"
#include "tests/support/capsule_body.h"

namespace {

using namespace rotunda;

constexpr double kCell = 0.010;
constexpr double kBin = 0.02;

capture::Matte matte_of(const recon::TriangleMesh& mesh, const capture::CameraModel& camera) {
  constexpr int kScale = 8;
  cv::Mat big = cv::Mat::zeros(camera.height * kScale, camera.width * kScale, CV_8UC1);
  std::vector<cv::Point2d> pixels;
  for (const auto& p : mesh.positions) {
    const auto pixel = capture::project(camera, p.cast<double>());
    pixels.emplace_back(pixel ? (pixel->x() + 0.5) * kScale - 0.5 : -1e4,
                        pixel ? (pixel->y() + 0.5) * kScale - 0.5 : -1e4);
  }
  for (const auto& t : mesh.triangles) {
    const std::vector<cv::Point> corners{pixels[t[0]], pixels[t[1]], pixels[t[2]]};
    cv::fillConvexPoly(big, corners, cv::Scalar(255));
  }
  capture::Matte matte;
  cv::resize(big, matte.alpha, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  return matte;
}

struct Cost {
  std::vector<double> wall_ms, cpu_ms;
};

void time_step(Cost& cost, const std::function<void()>& step) {
  const auto cpu = std::clock();
  const auto wall = std::chrono::steady_clock::now();
  step();
  cost.wall_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count());
  cost.cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
}

void print(const char* step, const Cost& cost) {
  fmt::print("{:<28} cpu {:8.1f} ms   wall {:8.1f} ms\n", step, median(cost.cpu_ms), median(cost.wall_ms));
}

// Distances from samples of one surface (its triangles' middles, weighted by area) to the nearest of the other.
std::vector<Eigen::Vector3f> samples_of(const recon::TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> samples;
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double area = 0.5 * static_cast<double>((b - a).cross(c - a).norm());
    const int across = std::max(1, static_cast<int>(std::ceil(std::sqrt(area / 4e-6))));  // one every 4 mm^2
    for (int i = 0; i < across; ++i)
      for (int j = 0; j < across - i; ++j) {
        const float u = (static_cast<float>(i) + 0.33F) / static_cast<float>(across);
        const float v = (static_cast<float>(j) + 0.33F) / static_cast<float>(across);
        samples.push_back(a + u * (b - a) + v * (c - a));
      }
  }
  return samples;
}

std::vector<double> nearest_distances(const std::vector<Eigen::Vector3f>& from,
                                      const std::vector<Eigen::Vector3f>& to) {
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> bins;
  const auto bin_of = [](const Eigen::Vector3f& p) -> Eigen::Vector3i {
    return (p.cast<double>() / kBin).array().floor().cast<int>();
  };
  const auto key = [](const Eigen::Vector3i& b) {
    const auto part = [](int c) { return static_cast<std::uint64_t>(c + 4096) & 0x1FFFU; };
    return part(b.x()) | (part(b.y()) << 13) | (part(b.z()) << 26);
  };
  for (std::size_t i = 0; i < to.size(); ++i) bins[key(bin_of(to[i]))].push_back(i);
  std::vector<double> distances;
  for (std::size_t s = 0; s < from.size(); s += 7) {
    double nearest = 1e9;
    for (int reach = 1; reach <= 16 && nearest > kBin * (reach - 1); ++reach)
      for (int dx = -reach; dx <= reach; ++dx)
        for (int dy = -reach; dy <= reach; ++dy)
          for (int dz = -reach; dz <= reach; ++dz) {
            if (reach > 1 && std::max({std::abs(dx), std::abs(dy), std::abs(dz)}) < reach) continue;
            const auto found = bins.find(key(bin_of(from[s]) + Eigen::Vector3i(dx, dy, dz)));
            if (found == bins.end()) continue;
            for (const auto i : found->second)
              nearest = std::min(nearest, static_cast<double>((to[i] - from[s]).norm()));
          }
    distances.push_back(nearest);
  }
  return distances;
}

void print_distance(const char* name, const recon::TriangleMesh& mesh, const recon::TriangleMesh& truth) {
  const auto surface = samples_of(mesh), body = samples_of(truth);
  auto accuracy = nearest_distances(surface, body), completeness = nearest_distances(body, surface);
  const auto within = std::count_if(completeness.begin(), completeness.end(), [](double d) { return d <= 0.020; });
  const double share = static_cast<double>(within) / static_cast<double>(completeness.size());
  accuracy.insert(accuracy.end(), completeness.begin(), completeness.end());
  std::sort(accuracy.begin(), accuracy.end());
  double sum = 0.0;
  for (const double d : accuracy) sum += d;
  fmt::print("{:<28} mean {:.1f} mm   p95 {:.1f} mm   truth within 20 mm {:.3f}\n", name,
             1e3 * sum / static_cast<double>(accuracy.size()), 1e3 * accuracy[accuracy.size() * 95 / 100], share);
}

void print_stages(const char* name, const std::vector<capture::CameraModel>& cameras,
                  const std::vector<capture::Matte>& mattes, const recon::SurfaceOptions& options) {
  const auto report = recon::reconstruct_surface(cameras, mattes, options).report;
  fmt::print("{}:", name);
  for (const auto& stage : report.stages) fmt::print(" {} {:.1f}", stage.name, stage.cpu_ms);
  fmt::print(" (ms of this thread), {} triangles\n", report.triangles);
}

void measure(const std::string& body, int runs) {
  const auto cameras = simulator::camera_layout();
  std::vector<capture::Matte> mattes;
  recon::TriangleMesh truth;
  if (body.empty()) {
    mattes = tests::mattes_of(tests::person(), cameras);
  } else {
    truth = recon::read_ply(body);
    for (const auto& camera : cameras) mattes.push_back(matte_of(truth, camera));
  }
  recon::SurfaceOptions options;
  options.bounds.emplace(Eigen::Vector3d(-1.5, -1.0, -0.1), Eigen::Vector3d(1.5, 1.0, 2.0));
  options.cell_size = kCell;
  Cost views_cost, hull_cost, cut_cost, cubes_cost, whole_cost, live_cost;
  recon::TriangleMesh hull;
  recon::SurfaceResult result;
  for (int run = 0; run < runs; ++run) {
    std::vector<recon::SilhouetteView> views;
    recon::SignedGrid grid;
    time_step(views_cost, [&] { views = recon::silhouette_views(cameras, mattes); });
    time_step(hull_cost, [&] { grid = recon::visual_hull(views, {.bounds = *options.bounds, .cell_size = kCell}); });
    time_step(cut_cost, [&] { recon::cut_to_genus_zero(grid); });
    time_step(cubes_cost, [&] { hull = recon::marching_cubes(grid); });
    time_step(whole_cost, [&] { result = recon::reconstruct_surface(cameras, mattes, options); });
    time_step(live_cost, [&] { recon::reconstruct_surface(cameras, mattes, recon::live_surface(options)); });
  }
  print("signed silhouettes", views_cost);
  print("visual hull", hull_cost);
  print("cut to genus 0", cut_cost);
  print("marching cubes", cubes_cost);
  print("reconstruct_surface, all", whole_cost);
  print("reconstruct_surface, live", live_cost);
  fmt::print("{} blocks, {} voxels, {} cut, {} -> {} triangles{}\n", result.report.blocks,
             result.report.cut.solid_voxels, result.report.cut.cut_voxels, result.report.extracted_triangles,
             result.report.triangles, result.failure.empty() ? "" : ", failed: " + result.failure);
  print_stages("full, silhouettes alone", cameras, mattes, options);
  print_stages("live", cameras, mattes, recon::live_surface(options));
  options.triangles = 0;  // the cost of decimation is of the triangles it takes away
  options.collapse_slivers = false;
  bench::print_growth(recon::silhouette_views(cameras, mattes), {}, options, runs);
  if (truth.triangles.empty()) return;
  print_distance("hull", hull, truth);
  print_distance("surface", result.mesh, truth);
}

}  // namespace

int main(int argc, char** argv) {
  std::string body, truth, keep;
  int runs = 5;
  CLI::App app("What the closed surface costs and how near it comes to the truth", "surface_bench");
  app.add_option("body", body, "a closed mesh that casts the silhouettes, PLY; else a person of capsules");
  app.add_option("--runs", runs, "of each step")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--truth", truth,
                 "measure every rung on rendered people instead: those that laws were fitted on, or others")
      ->check(CLI::IsMember({"fitted", "held-out", "all"}));
  bool fit = false, growth = false;
  app.add_flag("--fit", fit, "search the law by rim distance anew, on the rendered people it was fitted on");
  app.add_flag("--growth", growth, "time and memory from 20 to 5 mm cells of a rendered person, pictures matched");
  std::size_t studies = 0;
  app.add_option("--studies", studies, "of --truth, the first so many alone: a few minutes each")
      ->check(CLI::PositiveNumber);
  app.add_option("--keep", keep, "leave rendered pictures here for the next time");
  CLI11_PARSE(app, argc, argv);
  try {
    if (fit) bench::search_rim_law(bench::fitted_studies(), keep);
    if (growth) bench::print_growth(bench::held_out_studies().front(), keep, runs);
    if (!fit && !growth && truth.empty()) measure(body, runs);
    if (!truth.empty()) {
      auto looked_at = truth == "held-out" ? bench::held_out_studies() : bench::fitted_studies();
      if (truth == "all") std::ranges::copy(bench::held_out_studies(), std::back_inserter(looked_at));
      if (studies > 0 && studies < looked_at.size())
        looked_at.erase(looked_at.begin() + static_cast<long>(studies), looked_at.end());
      bench::print_ladder(looked_at, keep);
    }
    return kDone;
  } catch (...) {
    return report_current_exception("surface_bench");
  }
}
