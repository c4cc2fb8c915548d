#include "tests/bench/rim_law_search.h"

#include <fmt/format.h>

#include <limits>
#include <memory>

#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/rim_fit.h"
#include "recon/hull/visual_hull.h"
#include "simulator/studio/camera_layout.h"
#include "tests/bench/surface_score.h"

namespace rotunda::bench {
namespace {

constexpr double kCell = 0.010;

recon::TriangleMesh hull_of(std::span<const recon::SilhouetteView> views, double margin) {
  auto grid = recon::visual_hull(views, {.bounds = simulator::kStageVolume, .cell_size = kCell});
  recon::cut_to_genus_zero(grid);
  auto mesh = recon::marching_cubes(grid, margin);
  recon::compute_normals(mesh);
  return mesh;
}

// What all laws have in common of a moment.
struct Prepared {
  SurfaceMoment moment;
  std::unique_ptr<SurfaceJudge> judge;  // of the moment's body
  recon::TriangleMesh hull;
  std::vector<recon::Rim> rims;
  SurfaceScore ideal;
};

std::unique_ptr<Prepared> prepare(SurfaceMoment moment) {
  auto prepared = std::make_unique<Prepared>(Prepared{std::move(moment), nullptr, {}, {}, {}});
  auto& p = *prepared;
  p.judge = std::make_unique<SurfaceJudge>(p.moment.body);
  p.ideal = p.judge->score(hull_of(recon::silhouette_views(p.moment.cameras, p.moment.truth), 0.01));
  const auto views = recon::silhouette_views(p.moment.cameras, p.moment.mattes);
  p.hull = hull_of(views, 0.15);
  Eigen::AlignedBox3d box;
  for (const auto& position : p.hull.positions) box.extend(position.cast<double>());
  p.rims = recon::find_rims(views, {.bounds = box});
  return prepared;
}

double cost_of(const recon::RimFitOptions& options, const std::vector<std::unique_ptr<Prepared>>& all) {
  double mean = 0.0, p95 = 0.0;
  for (const auto& p : all) {
    auto mesh = p->hull;
    recon::fit_to_rims(mesh, p->rims, options);
    const auto score = p->judge->score(mesh);
    mean += score.mean / p->ideal.mean;
    p95 += score.p95 / p->ideal.p95;
  }
  const auto count = static_cast<double>(all.size());
  fmt::print("slope {:.2f}, farthest {:3.0f} mm, membrane {:3.0f} mm, pins {:4.1f}: {:.3f} / {:.3f}\n",
             options.law.slope, 1e3 * options.law.farthest, 1e3 * options.membrane_length, options.pin_weight,
             mean / count, p95 / count);
  std::fflush(stdout);
  return (mean + p95) / count;
}

}  // namespace

void search_rim_law(const std::vector<SurfaceStudy>& studies, const std::filesystem::path& keep) {
  std::vector<std::unique_ptr<Prepared>> all;
  for (const auto& study : studies)
    for (auto& moment : moments_of(study, keep)) all.push_back(prepare(std::move(moment)));
  recon::RimFitOptions best;
  best.cell_size = kCell;
  double least = cost_of(best, all);
  for (bool better = true; better;) {
    better = false;
    for (double recon::RimFitOptions::*number :
         {&recon::RimFitOptions::membrane_length, &recon::RimFitOptions::pin_weight})
      for (const double factor : {0.7, 1.4}) {
        auto tried = best;
        tried.*number *= factor;
        if (const double cost = cost_of(tried, all); cost < least) least = cost, best = tried, better = true;
      }
    for (double recon::RimLaw::*number : {&recon::RimLaw::slope, &recon::RimLaw::farthest})
      for (const double factor : {0.8, 1.25}) {
        auto tried = best;
        tried.law.*number *= factor;
        if (const double cost = cost_of(tried, all); cost < least) least = cost, best = tried, better = true;
      }
  }
  fmt::print("best:\n");
  cost_of(best, all);
}

}  // namespace rotunda::bench
