#include "recon/hull/capture_volume.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "config/errors.h"
#include "recon/hull/visual_hull.h"

namespace rotunda::recon {
namespace {

constexpr int kCubesAcross = 64;  // of each search

// Least-squares meeting point of the optical axes; parallel axes are held near the cameras' own middle.
Eigen::Vector3d aim_point(std::span<const SilhouetteView> views) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& view : views) middle += view.camera().centre() / static_cast<double>(views.size());
  constexpr double kHold = 1e-4;
  Eigen::Matrix3d normal = kHold * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = kHold * middle;
  for (const auto& view : views) {
    const Eigen::Vector3d axis = view.camera().axis().normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * view.camera().centre();
  }
  return normal.ldlt().solve(right);
}

Eigen::AlignedBox3d search_region(std::span<const SilhouetteView> views) {
  const Eigen::Vector3d aim = aim_point(views);
  double reach = 0.0;
  for (const auto& view : views) reach = std::max(reach, (view.camera().centre() - aim).norm());
  return {aim - Eigen::Vector3d::Constant(reach), aim + Eigen::Vector3d::Constant(reach)};
}

using Cubes = std::vector<Eigen::Vector3i>;

bool before(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

// Groups of touching cubes; `cubes` sorted by before().
std::vector<Cubes> groups_of(const Cubes& cubes) {
  std::vector<char> taken(cubes.size(), 0);
  const auto take = [&](const Eigen::Vector3i& cube, Cubes& group) {
    const auto found = std::lower_bound(cubes.begin(), cubes.end(), cube, before);
    if (found == cubes.end() || *found != cube) return;
    auto& mark = taken[static_cast<std::size_t>(found - cubes.begin())];
    if (mark == 0) group.push_back(cube);
    mark = 1;
  };
  std::vector<Cubes> groups;
  for (const auto& seed : cubes) {
    Cubes group;
    take(seed, group);
    for (std::size_t i = 0; i < group.size(); ++i)
      for (int n = 0; n < 27; ++n) take(group[i] + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), group);
    if (!group.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

// What as many cameras as possible see and none empties: where the performer surely is, if only in part.
Cubes core_cubes(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box, double cube) {
  VisualHullOptions options;
  for (options.min_views = static_cast<int>(views.size()); options.min_views >= 2; --options.min_views) {
    auto core = occupied_cubes(views, box, cube, options);
    if (core.empty()) continue;
    std::sort(core.begin(), core.end(), before);
    return core;
  }
  return {};
}

// Box of the group with most of the core: others are phantoms, say between two cameras that no third one watches.
Eigen::AlignedBox3i main_group(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box, double cube) {
  const auto core = core_cubes(views, box, cube);
  VisualHullOptions options;
  options.min_views = std::max(2, static_cast<int>(views.size()) / 3);
  auto cubes = occupied_cubes(views, box, cube, options);
  cubes.insert(cubes.end(), core.begin(), core.end());
  std::sort(cubes.begin(), cubes.end(), before);
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
  Eigen::AlignedBox3i main;
  std::pair<std::size_t, std::size_t> most{0, 0};
  for (const auto& group : groups_of(cubes)) {
    std::size_t shared = 0;
    for (const auto& c : group) shared += std::binary_search(core.begin(), core.end(), c, before) ? 1 : 0;
    const std::pair<std::size_t, std::size_t> size{shared, group.size()};
    if (size <= most) continue;
    most = size;
    main.setEmpty();
    for (const auto& c : group) main.extend(c);
  }
  return main;
}

[[noreturn]] void tell_nothing_left(std::span<const SilhouetteView> views) {
  std::string empty;
  for (const auto& view : views)
    if (view.is_empty()) empty += (empty.empty() ? "" : ", ") + view.camera().name;
  if (!empty.empty()) throw InvalidInput(fmt::format("empty silhouette in {}", empty));
  throw InvalidInput(
      "the silhouettes have no point of the world in common: check that calibration and mattes belong "
      "together");
}

}  // namespace

Eigen::AlignedBox3d capture_volume(std::span<const SilhouetteView> views) {
  if (views.size() < 2) throw InvalidInput("a volume cannot be found from fewer than two views");
  if (std::all_of(views.begin(), views.end(), [](const SilhouetteView& view) { return view.is_empty(); }))
    tell_nothing_left(views);
  Eigen::AlignedBox3d box = search_region(views);
  // The first search is as coarse as the cameras' distance; the second, within what it left, gives the box its edges.
  for (int round = 0; round < 2; ++round) {
    const double cube = box.sizes().maxCoeff() / kCubesAcross;
    const auto group = main_group(views, box, cube);
    if (group.isEmpty()) tell_nothing_left(views);
    const Eigen::Vector3d origin = box.min();
    box = Eigen::AlignedBox3d(origin + cube * group.min().cast<double>(),
                              origin + cube * (group.max() + Eigen::Vector3i::Ones()).cast<double>());
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(cube);
    box = Eigen::AlignedBox3d(box.min() - margin, box.max() + margin);
  }
  return box;
}

double default_cell_size(const Eigen::AlignedBox3d& bounds, const std::string& unit) {
  const double diagonal = bounds.diagonal().norm();
  return unit == "m" && diagonal >= 0.3 && diagonal <= 30.0 ? kPersonCell : diagonal / 200.0;
}

}  // namespace rotunda::recon
