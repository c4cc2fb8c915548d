#pragma once
// Draws a person as one camera sees it, with OpenGL ES: every vertex goes through the exact camera model (skew and
// distortion included), so that at triangles of 1 cm the outline is true to well below 0.05 px. Needs a current
// context.
#include <optional>

#include "capture/camera_model.h"
#include "playback/render/gl_objects.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {

// A part of the picture. Colours are linear light, already multiplied by alpha; alpha is the share of the pixel
// covered.
struct PersonLayer {
  cv::Rect box;           // in the picture; empty if the person is out of sight
  cv::Mat premultiplied;  // CV_32FC3, red, green, blue
  cv::Mat alpha;          // CV_32FC1
};

class PersonRenderer {
 public:
  // `supersampling`: samples a pixel along each axis.
  PersonRenderer(const Person& person, int supersampling);
  PersonLayer draw(const capture::CameraModel& camera, const recon::TriangleMesh& surface);

 private:
  const playback::RenderTarget& target_for(cv::Size size);

  const Person& person_;
  int supersampling_;
  playback::GlProgram program_;
  playback::GlTexture texture_;
  playback::GlBuffer corners_, vertices_;
  playback::GlVertexArray array_;
  std::optional<playback::RenderTarget> target_;
};

// Samples an axis that give about 3000 samples across the picture: never fewer than 2.
int default_supersampling(int picture_width);

}  // namespace rotunda::simulator
