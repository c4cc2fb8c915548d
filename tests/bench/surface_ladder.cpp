#include "tests/bench/surface_ladder.h"

#include <fmt/format.h>

#include <ctime>
#include <map>
#include <string>

#include "config/errors.h"
#include "recon/hull/surface.h"
#include "simulator/studio/camera_layout.h"
#include "tests/bench/surface_score.h"

namespace rotunda::bench {
namespace {

// What the surface is made from.
enum class Source { truth, key, own };  // true mattes; our key; our key by our own calibration

struct Rung {
  std::string name, asked;
  Source source;
  recon::SurfaceOptions options;
  bool pictures = true;
};

recon::SurfaceOptions options_of() {
  recon::SurfaceOptions options;
  options.bounds = simulator::kStageVolume;
  return options;
}

recon::SurfaceOptions bare_hull() {
  auto options = options_of();
  options.fit_rims = false;
  options.smoothing_rounds = 0;
  options.triangles = 0;
  options.collapse_slivers = false;
  return options;
}

std::vector<Rung> rungs() {
  auto paper = options_of(), rims = options_of(), trusting = options_of();
  paper.paper = true;
  rims.match_pictures = false;
  trusting.put_back_lost = false;
  return {{"ideal hull", "1 / 1", Source::truth, bare_hull(), false},
          {"our hull, true calibration", "-", Source::key, bare_hull(), false},
          {"our hull", "-", Source::own, bare_hull(), false},
          {"live", "<= 0.85 / 0.85", Source::own, recon::live_surface(options_of()), false},
          {"rims alone", "-", Source::own, rims, false},
          {"full", "<= 0.68 / 0.70, 0.91", Source::own, options_of()},
          {"rims, true calibration", "-", Source::key, rims, false},
          {"full, true calibration", "-", Source::key, options_of()},
          {"full, nothing put back", "-", Source::own, trusting},
          {"rims alone, all true", "0.61 / 0.60", Source::truth, rims, false},
          {"full, all true", "0.55 / 0.56", Source::truth, options_of()},
          {"paper", "-", Source::own, paper}};
}

struct Sums {
  double mean = 0.0, p95 = 0.0, within = 0.0, seen = 0.0, overlap = 0.0, normals_off = 0.0, cpu_ms = 0.0;
  int worse_than_hull = 0, failed = 0;
};

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Ladder {
 public:
  void add(const SurfaceMoment& moment) {
    const SurfaceJudge judge(moment.body, moment.cameras);
    seen_ += judge.seen_share();
    const std::map<Source, std::vector<recon::SilhouetteView>> views{
        {Source::truth, recon::silhouette_views(moment.cameras, moment.truth)},
        {Source::key, recon::silhouette_views(moment.cameras, moment.mattes)},
        {Source::own, recon::silhouette_views(moment.own_cameras, moment.own_mattes)}};
    SurfaceScore ideal;
    std::map<Source, double> hull;  // mean
    fmt::print("{:<30}", moment.name);
    for (std::size_t r = 0; r < rungs_.size(); ++r) {
      const auto& rung = rungs_[r];
      const double before = cpu_ms();
      const auto result = recon::reconstruct_surface(
          views.at(rung.source), rung.pictures ? moment.pictures : std::vector<cv::Mat>(), rung.options);
      sums_[r].cpu_ms += cpu_ms() - before;
      if (!result.failure.empty()) {
        ++sums_[r].failed;
        fmt::print("  {}: {}", rung.name, result.failure);
        continue;
      }
      const auto score = judge.score(result.mesh);
      if (r == 0) ideal = score;
      const double of_hull = hull.try_emplace(rung.source, score.mean).first->second;  // hulls come first
      if (score.mean > of_hull) ++sums_[r].worse_than_hull;
      sums_[r].mean += score.mean / ideal.mean;
      sums_[r].p95 += score.p95 / ideal.p95;
      sums_[r].within += score.within_10mm;
      sums_[r].seen += score.seen_within_10mm;
      sums_[r].normals_off += score.normals_off_deg;
      sums_[r].overlap += outline_overlap(result.mesh, moment.cameras, moment.truth);
      if (r == 0) fmt::print(" {:5.2f} / {:5.1f} mm {:.3f}", score.mean, score.p95, score.within_10mm);
      if (r != 0)
        fmt::print(" | {:.2f} / {:.2f} {:.3f}", score.mean / ideal.mean, score.p95 / ideal.p95, score.within_10mm);
    }
    fmt::print("\n");
    std::fflush(stdout);
    ++moments_;
  }

  void print_means() const {
    fmt::print("{:<26} {:>16} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}  {}\n", "mean", "to the ideal", "in 10 mm",
               "of seen", "outline", "normals", "cpu ms", "not worse", "asked");
    for (std::size_t r = 0; r < rungs_.size(); ++r) {
      const auto& sum = sums_[r];
      const double count = moments_ - sum.failed;
      fmt::print("{:<26} {:>7.3f} / {:>6.3f} {:>10.3f} {:>10.3f} {:>10.4f} {:>6.1f} deg {:>10.0f} {:>6}/{:<3}  {}\n",
                 rungs_[r].name, sum.mean / count, sum.p95 / count, sum.within / count, sum.seen / count,
                 sum.overlap / count, sum.normals_off / count, sum.cpu_ms / count,
                 moments_ - sum.worse_than_hull - sum.failed, moments_, rungs_[r].asked);
    }
    fmt::print("no camera has {:.3f} of the true surface before it\n", 1.0 - seen_ / moments_);
  }

 private:
  std::vector<Rung> rungs_ = rungs();
  std::vector<Sums> sums_ = std::vector<Sums>(rungs_.size());
  double seen_ = 0.0;  // shares of the truth that some camera sees
  int moments_ = 0;
};

}  // namespace

void print_ladder(const std::vector<SurfaceStudy>& studies, const std::filesystem::path& keep) {
  Ladder ladder;
  for (auto study : studies) {
    study.own_calibration = true;
    try {
      for (const auto& moment : moments_of(study, keep)) ladder.add(moment);
    } catch (const InvalidInput& problem) {  // the other studies can still be measured
      fmt::print("{} left out: {}\n", study.name(), problem.what());
    }
  }
  ladder.print_means();
}

}  // namespace rotunda::bench
