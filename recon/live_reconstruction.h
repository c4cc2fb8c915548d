#pragma once
// The live way through the house: one FrameSet to a coloured closed surface, within a frame time or two. The same steps
// as offline (frame_reconstruction.h), on half-size pictures, at coarser cells and without a sphere map (recon/live/).
// World frame, metres.
// Pure: no files, no log; the same result on any number of threads.
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame.h"
#include "capture/matte/live_key.h"
#include "recon/frame_reconstruction.h"
#include "recon/mesh/triangle_mesh.h"
#include "recon/stage_clock.h"

namespace rotunda::recon {

struct LiveOptions {
  std::optional<Eigen::AlignedBox3d> bounds;  // the rig's volume; searched for if not given
  double cell_size = 0.0;                     // of the hull, world units; 0: twice what it is offline
};

struct LiveView {
  capture::CameraId camera;
  std::size_t slot = 0;      // of the frame set and the studio
  capture::HalfMatte matte;  // with the half-size picture that it was found in
};

struct LiveFrame {
  TriangleMesh mesh;            // closed, of genus 0, with normals and colours; empty on failure
  std::vector<LiveView> views;  // what it was made from: of cameras that have a picture
  std::string failure;          // why there is no surface; empty if fine
};

// The key alone: no surface. Throws as reconstruct_live does.
LiveFrame key_live(const capture::FrameSet& frame_set, const StudioViews& studio, StageClock& clock);

// `studio` with live keys, or the frame is late; mattes do not vote on each other, and the hull keeps only what all
// views hold. A set with fewer than two pictures is a failure, not an error.
// Throws InvalidInput if pictures are not of the cameras' sizes.
LiveFrame reconstruct_live(const capture::FrameSet& frame_set, const StudioViews& studio, const LiveOptions& options,
                           StageClock& clock);

}  // namespace rotunda::recon
