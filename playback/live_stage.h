#pragma once
// The live view: the newest surface, seen by an eye that goes round the performer and follows, and beside it pictures
// of cameras. World frame, metres. Needs a current GLES 3 context.
#include <optional>
#include <vector>

#include "playback/render/mesh_renderer.h"
#include "playback/viewpoint.h"
#include "recon/live_surface.h"

namespace rotunda::playback {

struct LiveView {
  recon::LiveSurface surface;
  std::vector<cv::Mat> sides;  // CV_8UC3, RGB; none: the surface has all the room
};

class LiveStage {
 public:
  LiveStage();

  void show(const LiveView& view);
  // Into the bound framebuffer, which is of this size.
  void draw(int width, int height);

  Orbit& orbit() { return orbit_; }
  void look_from_front();
  DrawOptions& options() { return options_; }

 private:
  void follow(const recon::LiveSurface& surface);
  void draw_side(const cv::Mat& rgb, const cv::Rect& place, int height);

  MeshRenderer renderer_;
  GlTexture side_texture_;
  GlFramebuffer side_frame_;
  std::vector<cv::Mat> sides_;
  Orbit orbit_, front_;
  DrawOptions options_;
  std::optional<capture::Timestamp> shown_;  // the surface's moment
};

// Where the pictures beside the surface go, one below the other at the right, in a view of this size; rows from the
// top.
std::vector<cv::Rect> side_places(const std::vector<cv::Mat>& sides, int width, int height);

// One view as a picture of its own, CV_8UC3, RGB. Makes its own headless context.
cv::Mat live_picture(const LiveView& view, int width, int height);

}  // namespace rotunda::playback
