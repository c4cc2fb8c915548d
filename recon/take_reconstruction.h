#pragma once
// The offline way through the house: every frame of a take to a closed surface, to a geometry image, to the take's
// geometry video. Resumable: finished frames are kept in the take's recon/frames (frame_store.h).
#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "recon/camera_standing.h"
#include "recon/stage_clock.h"
#include "recon/take_alignment.h"

namespace rotunda::recon {

// Whether every frame is sampled at the same points of the performer (take_alignment.h). Where it fits: unless the
// surface that is carried leaves out much of what the frames show, a wide skirt or a prop.
enum class Alignment { none, where_it_fits, always };

enum class Quality { full, live };  // live: the live key (capture/matte/live_key.h), for a look at once

struct TakeReconstructionOptions {
  std::filesystem::path take;
  std::optional<std::filesystem::path> calibration;           // else the take's own
  std::optional<std::pair<std::size_t, std::size_t>> frames;  // half-open; else all
  double cell_size = 0.0;  // metres; 0: 10 mm, or by the volume where the unit is unknown
  int triangles = 20000;   // of the surface before mapping
  int level = 8;           // of the geometry image
  int colour_level = 8;
  int tolerate_misses = 0;                      // so many mattes may lack a part of the performer that the others show
  std::optional<Eigen::Vector2d> performer_at;  // of several people the one nearest to this x, y; else the largest
  double tied_litres = 0.0;  // props and people that touch nobody stay from this size on, on a thread; 0: dropped
  Quality quality = Quality::full;
  int jobs = 0;        // frames at once; 0: one a core
  bool paper = false;  // also write the paper's 24-bit AVI
  Alignment align = Alignment::none;
  std::optional<std::filesystem::path> reference;  // of the alignment: another take of the same person
  std::optional<std::filesystem::path> meshes;     // one PLY a frame
  std::optional<std::filesystem::path> mattes;     // DIR/<camera>/frame000000.png
};

struct FailedFrame {
  std::size_t frame = 0;
  std::string reason;
};

struct TakeReconstructionReport {
  std::filesystem::path video;  // empty if no frame could be mapped or it was interrupted
  std::size_t frames = 0;
  std::size_t mapped = 0;                        // of these, also those of an earlier run
  std::size_t resumed = 0;                       // of these, finished in an earlier run
  std::vector<FailedFrame> failed;               // in the video these are made from their neighbours and marked so
  std::vector<StageCost> stages;                 // of this run
  std::optional<TakeAlignmentReport> alignment;  // of the video; none: not asked for, or `unaligned` says why
  std::string unaligned;
  double wall_s = 0.0, cpu_s = 0.0;  // of this run, CPU of the whole process
  bool interrupted = false;
  std::vector<CameraStanding> cameras;  // of the take; also in recon/cameras.json
};

// Calls `progress` now and then, from any thread, one call at a time. Throws InvalidInput (no such frames, a camera
// missing in the calibration or of another size), ConfigError, CorruptData, std::system_error.
TakeReconstructionReport reconstruct_take(const TakeReconstructionOptions& options,
                                          const std::function<void(std::size_t done, std::size_t total)>& progress,
                                          std::stop_token stop);

}  // namespace rotunda::recon
