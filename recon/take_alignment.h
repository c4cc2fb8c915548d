#pragma once
// A reconstructed take's surfaces made to correspond: texel i of the geometry image is the same point of the performer
// in every frame, and in every other take that is aligned to the same reference. The reference is made of the take's
// own frames, or taken from another take of the same person that is aligned already: that is how character building
// gets all takes of a person into one lattice, `align_take({.take = B, .reference = A})`. Needs the frames that
// reconstruct_take left (frame_store.h); leaves recon/aligned (alignment_store.h). Resumable: finished frames stay.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "recon/stage_clock.h"

namespace rotunda::recon {

struct TakeAlignmentOptions {
  std::filesystem::path take;
  std::optional<std::filesystem::path> reference;             // another take's folder; else the take's own reference
  std::optional<std::filesystem::path> calibration;           // what the take was reconstructed with, if not its own
  std::optional<std::pair<std::size_t, std::size_t>> frames;  // half-open; else all that were reconstructed
  bool paper = false;  // spherical matching, frame after frame, as the first paper; else by a skeleton or tracking
  int jobs = 0;        // frames at once; 0: one a core
};

struct FrameAlignment {
  std::size_t frame = 0;                                 // of the take
  double residual_mean_mm = 0.0, residual_p95_mm = 0.0;  // the carried surface to the frame's own
  double stretch_p95 = 1.0;
  double uncovered = 0.0;  // share of the frame's own area that the carried surface does not reach
  std::size_t folds = 0;
};

struct TakeAlignmentReport {
  std::string how;  // "skeleton", "tracking" from frame to frame where there is nobody, or "matching" on the sphere
  std::string why_no_skeleton;         // for people; empty if there is one
  std::vector<FrameAlignment> frames;  // ascending; also in recon/aligned/report.json
  std::vector<StageCost> stages;       // of this run
  bool interrupted = false;

  double uncovered() const;  // of the median frame; 0 without frames
};

// Calls `progress` now and then, from any thread, one call at a time. The same result on any number of threads. Throws
// InvalidInput: the take is not reconstructed; the reference take is not aligned, or its person has a skeleton and
// nobody is found in this take; ConfigError, CorruptData, std::system_error.
TakeAlignmentReport align_take(const TakeAlignmentOptions& options,
                               const std::function<void(std::size_t done, std::size_t total)>& progress,
                               std::stop_token stop);

}  // namespace rotunda::recon
