#pragma once
// Plays a geometry video in a window, over and over, seen by an eye that the operator turns about the performer
// (take_desk.h: keys, mouse, gamepad). Between frames of an aligned video it shows what lies between them.
#include <memory>
#include <stop_token>

#include "playback/render/take_pictures.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct PlayOptions {
  int width = 1280, height = 720;  // pixels
  bool fullscreen = false;
  int level = 0;           // of detail; 0: the video's own
  long picture_limit = 0;  // pictures drawn before it ends by itself; 0: none
  // Of the take that the video was made of: draw it in their colours, no faster than they are keyed the first time.
  std::shared_ptr<TakePictures> pictures;
  std::stop_token stop;
};

struct PlayReport {
  long pictures = 0;      // drawn in the window
  long frames = 0;        // of the video shown
  long late = 0;          // pictures that had to show an older frame, as the right one was not yet decoded or keyed
  double seconds = 0.0;   // from the first picture to the last
  int lost_contexts = 0;  // of the graphics driver: everything was made anew
};

// Returns when the window is closed, the operator quits, or it is asked to stop. Call it on the program's first thread.
// Throws DeviceError without a display, and what the reader and the pictures throw.
PlayReport play(recon::GeometryVideoReader& video, const PlayOptions& options = {});

}  // namespace rotunda::playback
