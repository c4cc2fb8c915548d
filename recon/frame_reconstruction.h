#pragma once
// One FrameSet on its way through the house, as the first paper's figure 1 has it: pictures -> mattes -> closed
// surface -> sphere -> geometry image with colour. Pure: no files. World frame, metres.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/frame.h"
#include "capture/matte/backdrop_plate.h"
#include "capture/matte/live_key.h"
#include "capture/matte/matte.h"
#include "recon/frame_store.h"
#include "recon/hull/surface.h"
#include "recon/stage_clock.h"

namespace rotunda::recon {

struct ColourView;

// What the cameras of a take show beside the performer; a slot per camera of the take, in its order.
struct StudioViews {
  std::vector<capture::CameraModel> cameras;
  std::vector<cv::Mat> backgrounds;  // RGB clean plates; an empty picture where there is none
  // Linear light of the rig from the camera's (capture/calibration/colour_match.h); empty: all are the same.
  std::vector<Eigen::Matrix3d> colour;
  capture::Backdrop backdrop = capture::Backdrop::blue;
  std::optional<Eigen::AlignedBox3d> volume;  // of the rig: where the performer can be
  std::string unit = "m";                     // of the calibration
  std::vector<cv::Mat> stages;                // capture/matte/stage_mask.h, one a camera; none: anywhere
  // At live quality, instead of the full key, a slot a camera; without one, or with none at all: in full.
  std::vector<std::optional<capture::LiveKey>> live_keys;
};

// The cameras that have a picture of this frame, side by side.
struct FrameViews {
  std::vector<capture::CameraModel> cameras;
  std::vector<cv::Mat> pictures;       // RGB
  std::vector<capture::Image> images;  // the same as their cameras sent them; empty: nobody knows
  std::vector<capture::Matte> mattes;
  std::vector<Eigen::Matrix3d> colour;  // as StudioViews has it; empty: all are the same
  capture::Backdrop backdrop = capture::Backdrop::blue;
  std::vector<SilhouetteView> silhouettes;  // of the mattes; empty: not made yet
  std::vector<std::string> disagreeing;     // cameras whose mattes the others do not support
};

// `given_mattes` has a slot per camera as well (an empty alpha: key it); an empty span: key all. So has `held`
// (capture/matte/chroma_key.h); an empty span: nothing is. What is keyed in a known volume keeps only what the other
// views support (hull/matte_support.h).
FrameViews key_frame(const capture::FrameSet& frame_set, const StudioViews& studio,
                     std::span<const capture::Matte> given_mattes, StageClock& clock,
                     std::span<const cv::Mat> held = {});

// What surface_colour() wants of them: their own light, without spill (recon/colour/surface_colour.h).
std::vector<ColourView> colour_views(const FrameViews& views);

struct MappedFrame {
  std::optional<MappedSurface> surface;
  std::string failure;  // why there is none, e.g. "cam03: empty silhouette"
  SurfaceReport report;
};
MappedFrame map_frame(const FrameViews& views, const SurfaceOptions& options, StageClock& clock);

// Colours at the mesh's own vertices; those no camera sees take their neighbours'.
void colour_vertices(TriangleMesh& mesh, const FrameViews& views, StageClock& clock);

// The geometry image at `level` with colours at `colour_level`, unseen texels filled.
GeometryImage sample_frame(const MappedSurface& surface, const FrameViews& views, int level, int colour_level,
                           StageClock& clock);

// A frame that failed, made from its neighbours: positions and colours in between by `share` (0: a, 1: b).
GeometryImage interpolate(const GeometryImage& a, const GeometryImage& b, double share);

}  // namespace rotunda::recon
