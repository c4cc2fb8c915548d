// What the way from a mesh to its geometry image costs and how good it is, one block of figures a mesh:
//   sphere_bench [--near SPHERES.txt] BODY.ply...
// Times are medians of five runs; the baseline in the same run is the map without relaxation (kernel insertion alone).
// "Tips" are the points within 3 cm of a limb's end: the places farthest from the body's middle along the surface.
// --near names other places to report apart (fingers): a line each, "x y z radius" in metres. With several meshes the
// growth exponent of the time over the number of triangles comes last.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <vector>

#include "config/exit_code.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/progressive_mesh.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_map.h"
#include "tests/support/surface_distance.h"

namespace {

using namespace rotunda;
using recon::TriangleMesh;

constexpr std::size_t kPoints = 100000;  // on each surface, beside all vertices

struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

std::vector<Ball> read_balls(const std::string& file) {
  std::vector<Ball> balls;
  std::ifstream stream(file);
  for (Ball ball; stream >> ball.centre[0] >> ball.centre[1] >> ball.centre[2] >> ball.radius;) balls.push_back(ball);
  return balls;
}

std::vector<std::vector<std::uint32_t>> neighbours_of(const TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) neighbours[t[i]].push_back(t[(i + 1) % 3]);
  return neighbours;
}

// Along the edges (Dijkstra 1959).
std::vector<double> distances_along(const TriangleMesh& mesh, const std::vector<std::vector<std::uint32_t>>& neighbours,
                                    std::uint32_t start) {
  std::vector<double> distance(mesh.positions.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<std::pair<double, std::uint32_t>> queue;
  queue.push({0.0, start});
  distance[start] = 0.0;
  while (!queue.empty()) {
    const auto [negative, at] = queue.top();
    queue.pop();
    if (-negative > distance[at]) continue;
    for (const auto next : neighbours[at]) {
      const double there = distance[at] + static_cast<double>((mesh.positions[next] - mesh.positions[at]).norm());
      if (there >= distance[next]) continue;
      distance[next] = there;
      queue.push({-there, next});
    }
  }
  return distance;
}

// Vertices farther from the vertex nearest to the bounding box's middle than all others within 3 cm of them.
std::vector<Ball> limb_tips(const TriangleMesh& mesh) {
  constexpr double kReach = 0.03;
  Eigen::AlignedBox3f box;
  for (const auto& p : mesh.positions) box.extend(p);
  std::uint32_t middle = 0;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    if ((mesh.positions[v] - box.center()).norm() < (mesh.positions[middle] - box.center()).norm()) middle = v;
  const auto neighbours = neighbours_of(mesh);
  const auto distance = distances_along(mesh, neighbours, middle);
  std::vector<Ball> tips;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (neighbours[v].empty() ||
        std::any_of(neighbours[v].begin(), neighbours[v].end(), [&](auto n) { return distance[n] > distance[v]; }))
      continue;
    const auto around = distances_along(mesh, neighbours, v);
    bool farthest = true;
    for (std::uint32_t u = 0; u < around.size() && farthest; ++u)
      farthest = around[u] > kReach || distance[u] <= distance[v];
    if (farthest) tips.push_back({mesh.positions[v].cast<double>(), kReach});
  }
  return tips;
}

struct Cost {
  double wall = 0.0, cpu = 0.0;  // seconds
};

Cost median_cost(const std::function<void()>& work) {
  std::vector<double> wall, cpu;
  for (int run = 0; run < 5; ++run) {
    const auto cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    work();
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    cpu.push_back(static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
  }
  std::sort(wall.begin(), wall.end());
  std::sort(cpu.begin(), cpu.end());
  return {wall[2], cpu[2]};
}

// Triangles that are flipped once each direction is stored as three floats.
std::size_t flips_in_float(const TriangleMesh& mesh, recon::SphereMap map) {
  for (auto& point : map.points) point = point.cast<float>().cast<double>();
  return recon::flipped_triangles(mesh, map);
}

void print_error(const char* name, const std::vector<tests::PointDistance>& points) {
  const auto error = tests::summary_of(points);
  fmt::print("  {:<22} mean {:.3f} p95 {:.2f} p99 {:.2f} max {:.1f} mm\n", name, 1e3 * error.mean, 1e3 * error.p95,
             1e3 * error.p99, 1e3 * error.max);
}

std::vector<tests::PointDistance> inside(const std::vector<tests::PointDistance>& points,
                                         const std::vector<Ball>& balls) {
  std::vector<tests::PointDistance> result;
  for (const auto& point : points)
    if (std::any_of(balls.begin(), balls.end(),
                    [&](const Ball& ball) { return (point.point - ball.centre).norm() <= ball.radius; }))
      result.push_back(point);
  return result;
}

void print_errors(const TriangleMesh& mesh, const TriangleMesh& rebuilt, const std::vector<Ball>& near) {
  auto points = tests::point_distances(mesh, rebuilt, kPoints);
  const auto share = [&](double limit) {
    return 100.0 *
           static_cast<double>(
               std::count_if(points.begin(), points.end(), [&](const auto& p) { return p.distance <= limit; })) /
           static_cast<double>(points.size());
  };
  const double within_1 = share(1e-3), within_2 = share(2e-3);
  const auto back = tests::point_distances(rebuilt, mesh, kPoints);
  points.insert(points.end(), back.begin(), back.end());
  print_error("symmetric error", points);
  const auto tips = limb_tips(mesh);
  print_error(fmt::format("at {} tips", tips.size()).c_str(), inside(points, tips));
  if (!near.empty()) print_error("at the given places", inside(points, near));
  fmt::print("  original within 1 mm {:.3f} %, 2 mm {:.4f} %; rebuilt is a sphere: {}\n", within_1, within_2,
             recon::topology_of(rebuilt).is_sphere() ? "yes" : "NO");
}

// Prints a mesh's block. How many triangles it has and the cost of the whole way, zero without a map.
std::pair<std::size_t, Cost> measure(const std::string& file, const std::vector<Ball>& near) {
  const auto mesh = recon::read_ply(file);
  const auto [map, report] = recon::map_to_sphere(mesh);
  fmt::print("{}: {} triangles\n", file, mesh.triangles.size());
  if (!map) {
    fmt::print("  no map: {}\n", report.failure);
    return {mesh.triangles.size(), {}};
  }
  const auto simplifying = median_cost([&] { recon::simplify_to_tetrahedron(mesh); });
  recon::SphereMapOptions unrelaxed;
  unrelaxed.passes = 0;
  const auto baseline = median_cost([&] { recon::map_to_sphere(mesh, unrelaxed); });
  const auto mapping = median_cost([&] { recon::map_to_sphere(mesh); });
  const auto sampling = median_cost([&] { recon::resample(mesh, *map, 8); });
  const Cost all{mapping.wall + sampling.wall, mapping.cpu + sampling.cpu};
  fmt::print("  progressive mesh {:.3f} s, without relaxation {:.3f} s, sphere map (all) {:.3f} s CPU, {} passes\n",
             simplifying.cpu, baseline.cpu, mapping.cpu, report.passes);
  fmt::print("  geometry image 257 {:.3f} s CPU; mesh to image: wall {:.3f} s, CPU {:.3f} s\n", sampling.cpu, all.wall,
             all.cpu);
  fmt::print("  flips {}, as float {}, |area - 4 pi| {:.1e}\n", report.flips, flips_in_float(mesh, *map),
             report.area_error);
  fmt::print("  area/vertex min {:.3f} p5 {:.3f} p50 {:.3f} p95 {:.3f}, p95/p5 {:.2f}\n", report.spread.min,
             report.spread.p5, report.spread.p50, report.spread.p95, report.spread.p95 / report.spread.p5);
  print_errors(mesh, recon::remesh(recon::resample(mesh, *map, 8)), near);
  return {mesh.triangles.size(), all};
}

// Slope of log(seconds) over log(triangles), by least squares.
double growth(const std::vector<std::pair<double, double>>& size_and_time) {
  Eigen::MatrixX2d a(size_and_time.size(), 2);
  Eigen::VectorXd b(size_and_time.size());
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    a.row(i) << 1.0, std::log(size_and_time[static_cast<std::size_t>(i)].first);
    b[i] = std::log(size_and_time[static_cast<std::size_t>(i)].second);
  }
  return a.colPivHouseholderQr().solve(b)[1];
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> meshes;
  std::string near_file;
  CLI::App app("From a mesh to its geometry image: cost and error", "sphere_bench");
  app.add_option("meshes", meshes, "bodies (PLY)")->required()->check(CLI::ExistingFile);
  app.add_option("--near", near_file, "places to report apart: a line each, x y z radius, metres")
      ->check(CLI::ExistingFile);
  CLI11_PARSE(app, argc, argv);
  try {
    const auto near = near_file.empty() ? std::vector<Ball>{} : read_balls(near_file);
    std::vector<std::pair<double, double>> size_and_time;
    for (const auto& file : meshes) {
      const auto [triangles, cost] = measure(file, near);
      if (cost.cpu > 0.0) size_and_time.emplace_back(static_cast<double>(triangles), cost.cpu);
    }
    if (size_and_time.size() > 2) fmt::print("growth: CPU time ~ triangles ^ {:.2f}\n", growth(size_and_time));
    return kDone;
  } catch (...) {
    return report_current_exception("sphere_bench");
  }
}
