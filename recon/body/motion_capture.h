#pragma once
// Marker-less motion capture (de Aguiar et al. 2007, 5.1) from silhouettes: a start out of any upright frame, the
// template's lengths and widths solved over some forty frames together, then every frame followed from there to both
// ends. World, metres.
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "recon/body/captured_motion.h"
#include "recon/body/outline_source.h"

namespace rotunda::recon {

struct MotionCaptureOptions {
  std::optional<std::pair<std::size_t, std::size_t>> frames;  // half-open; else all
  bool only_overlap = false;                                  // the paper's: silhouette overlap alone
  std::optional<BodyTemplate> body;                           // the person's, known from another take; else solved
};

struct MotionCaptureReport {
  CapturedMotion motion;
  std::size_t start_frame = 0;  // where it found the person standing
  std::vector<StageCost> stages;
  double wall_s = 0.0, cpu_s = 0.0;
  bool interrupted = false;  // then there is no motion
};

// Equal on any number of threads. Throws InvalidInput that says what to do: nobody in the silhouettes, no upright
// frame, nobody of the known measures; and what the source throws.
MotionCaptureReport capture_motion(OutlineSource& source, const MotionCaptureOptions& options,
                                   const std::function<void(std::size_t done, std::size_t total)>& progress,
                                   std::stop_token stop);

}  // namespace rotunda::recon
