#pragma once
// Draws figures as one camera sees them while its shutter is open, with OpenGL ES: every vertex goes through the exact
// camera model (skew and distortion included), so that at triangles of 1 cm the outline is true to well below 0.05 px.
// Moving figures are drawn at several moments of the exposure, each with sub-pixel places of its own: the samples of a
// pixel are spread over time and area alike (Cook, Porter, Carpenter 1984), and blur costs vertices but no pixels.
// Needs a current context.
#include <optional>
#include <vector>

#include "capture/camera_model.h"
#include "playback/render/gl_objects.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

// Figures while a shutter is open. In between vertices go straight: over 5 ms a foot in full swing is 0.3 mm off.
struct LitFigures {
  std::vector<recon::TriangleMesh> opening, closing;  // surfaces when the shutter opens and closes, one a figure
  std::vector<std::vector<Eigen::Vector3f>> light;    // that falls on each vertex
};

// A part of the picture: linear light, already multiplied by alpha; alpha is the share of the pixel covered.
struct FigureLayer {
  cv::Rect box;  // in the picture; empty if no figure is in sight
  cv::Mat rgba;  // CV_32FC4: red, green, blue, alpha
};

class FigureRenderer {
 public:
  // `figures` are lent. `supersampling`: samples a pixel along each axis.
  FigureRenderer(const std::vector<Figure>& figures, int supersampling);
  FigureLayer draw(const capture::CameraModel& camera, const LitFigures& figures);

 private:
  struct DrawnFigure {  // what of a figure lies with the renderer
    playback::GlTexture texture;
    std::vector<Eigen::Vector2f> corners;  // of every triangle, 0 to 1 in the texture
    bool is_closed = false;                // nobody sees its inside
  };
  static DrawnFigure upload(const Figure& figure);
  const playback::RenderTarget& target_for(cv::Size size);

  int supersampling_;
  playback::GlProgram program_;
  playback::GlBuffer vertices_;
  playback::GlVertexArray array_;
  std::vector<DrawnFigure> drawn_;
  std::optional<playback::RenderTarget> target_;
};

// Samples an axis that give about 3000 samples across the picture: never fewer than 2.
int default_supersampling(int picture_width);

}  // namespace rotunda::simulator
