#pragma once
// Draws figures as one camera sees them, with OpenGL ES: every vertex goes through the exact camera model (skew and
// distortion included), so that at triangles of 1 cm the outline is true to well below 0.05 px. Needs a current
// context.
#include <optional>
#include <vector>

#include "capture/camera_model.h"
#include "playback/render/gl_objects.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

// A part of the picture. Colours are linear light, already multiplied by alpha; alpha is the share of the pixel
// covered.
struct FigureLayer {
  cv::Rect box;           // in the picture; empty if no figure is in sight
  cv::Mat premultiplied;  // CV_32FC3, red, green, blue
  cv::Mat alpha;          // CV_32FC1
};

class FigureRenderer {
 public:
  // `figures` are lent. `supersampling`: samples a pixel along each axis.
  FigureRenderer(const std::vector<Figure>& figures, int supersampling);
  FigureLayer draw(const capture::CameraModel& camera, const std::vector<recon::TriangleMesh>& surfaces);

 private:
  struct DrawnFigure {  // what of a figure lies with the renderer
    playback::GlTexture texture;
    playback::GlBuffer corners, vertices;
    playback::GlVertexArray array;
  };
  static DrawnFigure upload(const Figure& figure);
  const playback::RenderTarget& target_for(cv::Size size);

  const std::vector<Figure>& figures_;
  int supersampling_;
  playback::GlProgram program_;
  std::vector<DrawnFigure> drawn_;
  std::optional<playback::RenderTarget> target_;
};

// Samples an axis that give about 3000 samples across the picture: never fewer than 2.
int default_supersampling(int picture_width);

}  // namespace rotunda::simulator
