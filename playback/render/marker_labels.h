#pragma once
// Numbered dots on a surface that is drawn already: hidden where it hides them or is turned away, of one size whatever
// the distance. Where they are crowded only some have their numbers, more as they come closer.
// World frame, metres. Needs a current GLES 3 context.
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "playback/render/gl_objects.h"
#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

struct MarkerLabel {
  Eigen::Vector3f place = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  // outwards; any length
  recon::Colour colour{255, 255, 255};
  std::string text;
  bool selected = false;    // drawn larger, with a ring
  bool goes_along = false;  // with the selected one: a thin ring
  bool looks_like(const MarkerLabel& other) const {
    return colour == other.colour && text == other.text && selected == other.selected && goes_along == other.goes_along;
  }
};

// Which of them have room for their text: no two overlap, the selected first, then as they are listed.
std::vector<bool> with_text(std::span<const MarkerLabel> labels, const Viewpoint& viewpoint);

class MarkerLabels {
 public:
  MarkerLabels();
  void set(std::vector<MarkerLabel> labels);
  // Into the bound framebuffer, whose depths are of `range`. The viewpoint's distortion must be none.
  void draw(const Viewpoint& viewpoint, const DepthRange& range);

 private:
  void paint_cells();

  GlProgram program_;
  GlVertexArray vertices_;
  GlBuffer places_, shown_;
  GlTexture cells_;
  std::vector<MarkerLabel> labels_;
};

}  // namespace rotunda::playback
