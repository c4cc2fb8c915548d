#pragma once
// A take's own picture made ready to be seen from elsewhere (view_dependent_renderer.h): without the backdrop's light
// and colour, and with how far each pixel can be trusted to show the performer.
#include <opencv2/core.hpp>
#include <vector>

#include "capture/camera_model.h"
#include "recon/colour/surface_colour.h"
#include "recon/frame_reconstruction.h"

namespace rotunda::playback {

struct SourceView {
  capture::CameraModel camera;
  cv::Mat
      rgba;  // CV_8UC4 of the camera's size: colours of the rig; alpha 0 outside of the matte, rising from 1 at the
             // outline to 255 some pixels inside. No pixel has the backdrop's colour: outside, the performer's go on
};

// Throws InvalidInput if picture and matte are not of the camera's size.
SourceView source_view(const recon::ColourView& view, capture::Backdrop backdrop);
std::vector<SourceView> source_views(const recon::FrameViews& views);

}  // namespace rotunda::playback
