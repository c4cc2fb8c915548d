#pragma once
// The live way through the house: one FrameSet to a coloured closed surface, within a frame time or two. The same
// functions as offline (frame_reconstruction.h), at coarser cells and without a sphere map. World frame, metres.
// Pure: no files, no log; the same result on any number of threads.
#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "capture/frame.h"
#include "recon/frame_reconstruction.h"
#include "recon/mesh/triangle_mesh.h"
#include "recon/stage_clock.h"

namespace rotunda::recon {

struct LiveOptions {
  std::optional<Eigen::AlignedBox3d> bounds;  // the rig's volume; searched for if not given
  double cell_size = 0.0;                     // of the hull, world units; 0: twice what it is offline
};

struct LiveFrame {
  TriangleMesh mesh;    // closed, with normals and colours; empty on failure
  FrameViews views;     // what it was made from, with mattes
  std::string failure;  // why there is no surface; empty if fine
};

// `studio` with live keys, or the frame is late; without `volume`: the vote between mattes costs more than all the
// rest, and the hull keeps only what all views hold. A set with fewer than two pictures is a failure, not an error.
// Throws InvalidInput if pictures are not of the cameras' sizes.
LiveFrame reconstruct_live(const capture::FrameSet& frame_set, const StudioViews& studio, const LiveOptions& options,
                           StageClock& clock);

}  // namespace rotunda::recon
