#pragma once
// The picture of the editor of markers: template and scan side by side with their numbered dots, in grey or in the
// colours of their distance from each other, the motion's bar below, what the desk says above. Needs a current GLES 3
// context.
#include <memory>

#include "playback/marker_desk.h"
#include "playback/marker_preview.h"
#include "playback/render/marker_labels.h"
#include "playback/render/mesh_renderer.h"
#include "playback/render/overlay.h"

namespace rotunda::playback {

recon::Colour segment_colour(std::size_t segment);  // left sides bright, right ones pale

inline constexpr double kResidualScale = 0.030;  // metres: the last colour of the scale
recon::Colour residual_colour(float distance);

class MarkerView {
 public:
  // Makes `preview` what is drawn, with the desk's markers on it.
  void show(std::shared_ptr<const Preview> preview, const MarkerDesk& desk);
  // Into the bound framebuffer, all of it.
  void draw(const MarkerDesk& desk, const MarkerLayout& layout, const std::vector<std::string>& lines);
  const Preview& shown() const { return *shown_; }

 private:
  struct Half {
    MeshRenderer body;
    MarkerLabels labels;
  };
  void upload(const Preview& preview);
  void set_labels(const MarkerDesk& desk);
  void draw_half(Half& half, MarkerSide side, const MarkerDesk& desk, const MarkerLayout& layout);
  void draw_overlays(const MarkerDesk& desk, const MarkerLayout& layout, const std::vector<std::string>& lines);

  Half left_, right_;
  Overlay overlay_;
  std::shared_ptr<const Preview> shown_;
};

}  // namespace rotunda::playback
