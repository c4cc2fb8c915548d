// Verdicts and advice: judge() of calibration_quality.h.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "capture/calibration/calibration_quality.h"

namespace rotunda::capture {
namespace {

// What a rig that carves surfaces to a centimetre needs. An error of a pixel at 4 m and 900 px of focal length is 4 mm.
constexpr double kGoodRms = 0.5, kWorstRms = 1.5;            // pixels
constexpr double kGoodCentre = 0.005, kWorstCentre = 0.030;  // metres, standard deviation
constexpr int kGoodViews = 12, kFewestTrusted = 5;           // boards a camera
constexpr double kGoodRadius = 0.75;  // of the picture's: beyond the outermost corner distortion may be a guess
constexpr double kGoodRim = 0.5;      // pixels, standard deviation at the picture's rim
constexpr double kMisfit = 0.5;       // pixels: steep, blurred corners left out for accuracy's sake are off by less
constexpr double kGoodMisfits = 0.05, kWorstMisfits = 0.25;  // share of corners
constexpr double kHeldOutGrows = 1.5;                        // against the residual itself
constexpr double kSameDistance = 1.3;                        // farthest / nearest below it: all at one distance

Verdict worse(Verdict a, Verdict b) {
  return std::max(a, b);
}

struct Third {
  const char* name;
  int count;
};

// Corners in the picture's ninths.
std::array<Third, 9> thirds_of(const ImageCoverage& coverage) {
  std::array<Third, 9> thirds = {{{"upper left", 0},
                                  {"top", 0},
                                  {"upper right", 0},
                                  {"left", 0},
                                  {"middle", 0},
                                  {"right", 0},
                                  {"lower left", 0},
                                  {"bottom", 0},
                                  {"lower right", 0}}};
  for (int y = 0; y < coverage.rows; ++y)
    for (int x = 0; x < coverage.columns; ++x) {
      const int third = 3 * (y * 3 / coverage.rows) + x * 3 / coverage.columns;
      thirds[static_cast<std::size_t>(third)].count +=
          coverage.corners[static_cast<std::size_t>(y * coverage.columns + x)];
    }
  return thirds;
}

std::vector<std::string> names_where(const ImageCoverage& coverage, bool covered) {
  std::vector<std::string> names;
  for (const auto& third : thirds_of(coverage))
    if ((third.count > 0) == covered) names.emplace_back(third.name);
  return names;
}

std::string listed(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

// "cam07 saw the board 4 times, all in the lower left: show it upper right, nearer than 2 m".
std::string seen_where(const std::string& name, const CameraQuality& quality) {
  const auto& coverage = quality.coverage;
  const auto where = names_where(coverage, true), missing = names_where(coverage, false);
  if (quality.views == 0)
    return fmt::format(
        "{}: no board it saw agrees with what the others saw: show it the board anew, all over its picture", name);
  std::string text = fmt::format("{} saw the board {}", name, in_times(static_cast<std::size_t>(quality.views)));
  if (where.size() <= 3) text += fmt::format(", all {} {}", where.size() == 1 ? "in the" : "in", listed(where));
  text += ": show it ";
  text += missing.empty() ? "more often, in the corners of its picture" : listed(missing);
  if (coverage.farthest < kSameDistance * coverage.nearest)
    text += fmt::format(", nearer than {:.1f} m", 0.8 * coverage.nearest);
  return text;
}

// Where lenses are known one board can tell where a camera stands: how well, its deviation says.
void judge_counts(const std::string& name, bool kept_intrinsics, CameraQuality& quality) {
  if (kept_intrinsics) {
    if (quality.views < kFewestTrusted) {
      quality.verdict = worse(quality.verdict, Verdict::usable);
      quality.advice.push_back(seen_where(name, quality));
    }
    return;
  }
  // Without corners out there it depends on their number and sharpness farther in: the adjustment knows.
  const bool few = quality.views < kGoodViews;
  const bool narrow = quality.views != 0 && quality.coverage.outermost_radius < kGoodRadius &&
                      (quality.deviation.rim_px == 0.0 || quality.deviation.rim_px > kGoodRim);
  if (few || narrow || names_where(quality.coverage, false).size() > 2)
    quality.advice.push_back(seen_where(name, quality));
  if (narrow) {
    const double rim = quality.deviation.rim_px;
    quality.advice.push_back(fmt::format(
        "{}: no corner lies farther out than {:.0f} % of the picture's radius, so its lens is {} at the rim: "
        "bring the board into the corners of its picture",
        name, 100.0 * quality.coverage.outermost_radius,
        rim > 0.0 ? fmt::format("known to {:.1f} px only", rim) : "a guess"));
    quality.verdict = worse(quality.verdict, Verdict::usable);
  }
  if (few) quality.verdict = worse(quality.verdict, Verdict::usable);
  if (quality.views < kFewestTrusted) quality.verdict = Verdict::rejected;
}

// Of a camera's corners, the share that are no corners of the board.
double misfit_share(const CalibrationResult& result, std::size_t camera) {
  int misfits = 0, corners = 0;
  for (const auto& view : result.views) {
    if (view.camera != camera) continue;
    corners += static_cast<int>(view.corners.size());
    misfits += static_cast<int>(std::count_if(view.corners.begin(), view.corners.end(), [](const auto& corner) {
      return corner.outlier && (corner.off.isZero() || corner.off.norm() > kMisfit);  // zero: seen from behind
    }));
  }
  return misfits / std::max(1.0, static_cast<double>(corners));
}

void judge_residuals(const std::string& name, double misfits, CameraQuality& quality) {
  if (quality.rms_px > kGoodRms) {
    quality.verdict = worse(quality.verdict, quality.rms_px > kWorstRms ? Verdict::rejected : Verdict::usable);
    quality.advice.push_back(fmt::format(
        "{}: corners are {:.2f} px off: look for motion blur (hold the board still), a soft focus or a bent board",
        name, quality.rms_px));
  }
  if (misfits > kGoodMisfits) {
    quality.verdict = worse(quality.verdict, misfits > kWorstMisfits ? Verdict::rejected : Verdict::usable);
    quality.advice.push_back(
        fmt::format("{}: {:.0f} % of its corners fit nothing and were left out", name, 100.0 * misfits));
  }
  if (quality.held_out_rms_px > kHeldOutGrows * quality.rms_px + 0.05) {
    quality.verdict = worse(quality.verdict, Verdict::usable);
    quality.advice.push_back(
        fmt::format("{}: at what took no part it is {:.2f} px off instead of {:.2f}: show "
                    "the board at more places",
                    name, quality.held_out_rms_px, quality.rms_px));
  }
}

void judge_deviation(const std::string& name, CameraQuality& quality) {
  const double centre = quality.deviation.centre;
  if (centre <= kGoodCentre) return;
  quality.verdict = worse(quality.verdict, centre > kWorstCentre ? Verdict::rejected : Verdict::usable);
  quality.advice.push_back(
      fmt::format("{}: where it stands is known to {:.0f} mm only: show it and its neighbours the "
                  "board together, nearer and tilted",
                  name, 1e3 * centre));
}

}  // namespace

std::string uncovered_places(const ImageCoverage& coverage) {
  return listed(names_where(coverage, false));
}

std::size_t uncovered_count(const ImageCoverage& coverage) {
  return names_where(coverage, false).size();
}

void judge(CalibrationResult& result) {
  std::vector<std::string> rejected;
  bool usable_only = false;
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const auto& name = result.cameras[i].name;
    auto& quality = result.quality[i];
    judge_counts(name, result.kept_intrinsics, quality);
    judge_residuals(name, misfit_share(result, i), quality);
    judge_deviation(name, quality);
    result.verdict = worse(result.verdict, quality.verdict);
    if (quality.verdict == Verdict::rejected) rejected.push_back(name);
    if (quality.verdict != Verdict::good) usable_only = true;
  }
  if (!result.problems.empty()) result.verdict = worse(result.verdict, Verdict::usable);
  if (!rejected.empty())
    result.advice.push_back(fmt::format("record boards again for {}, then calibrate anew", listed(rejected)));
  else if (usable_only)
    result.advice.push_back("it will do; more boards where cameras ask for them make it good");
}

}  // namespace rotunda::capture
