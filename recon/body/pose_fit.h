#pragma once
// Fits poses, and a template's measures, to silhouettes: damped Gauss-Newton on twists over all views, both contours,
// within joint limits, near what time and anatomy expect. World, metres.
// Pure; the same result on any number of threads.
#include <optional>
#include <span>
#include <vector>

#include "recon/body/pose_equations.h"

namespace rotunda::recon {

struct PoseFitOptions {
  int iterations = 8;
  double first_scale = 0.15, last_scale = 0.04;  // of the robust weight, metres: narrowing from step to step
  std::optional<Pose> expected;                  // by the frames before
  double expected_sigma = 0.20;                  // radians a joint may be off from it; metres/4 for the root
  bool only_overlap = false;                     // the paper's: silhouettes and joint limits alone
  double spacing_px = 6.0;
};

struct PoseFit {
  Pose pose;
  double residual = 0.0;                    // rms distance of rim and outline, cut at 10 cm, metres
  double explained = 0.0;                   // share of rim and outline points that have a partner within 4 cm: 0..1
  std::array<double, kBodyJoints> sigma{};  // standard deviation of a joint's position, metres
  std::array<double, kBodyJoints> confidence{};  // 0 (guessed) .. 1 (well seen, and it fits)
};
PoseFit fit_pose(const BodyTemplate& body, const FrameOutlines& frame, const Pose& start,
                 const PoseFitOptions& options);

// Measures and all poses together: the poses are eliminated frame by frame (Schur complement). Measures stay near
// those of an adult of the template's height as far as silhouettes allow.
struct BodyFit {
  BodyTemplate body;
  std::vector<Pose> poses;
};
BodyFit fit_body(const BodyTemplate& body, std::span<const FrameOutlines> frames, std::span<const Pose> poses,
                 int iterations);

}  // namespace rotunda::recon
