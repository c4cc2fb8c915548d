#pragma once
// Draws figures as one camera sees them while its shutter is open: every vertex goes through the exact camera model
// (skew and distortion included), so that at triangles of 1 cm the outline is true to well below 0.05 px. Moving
// figures are drawn at several moments of the exposure, each with sub-pixel places of its own: the samples of a pixel
// are spread over time and area alike (Cook, Porter, Carpenter 1984), and blur costs vertices but no samples.
// Runs on the processor: the same pixels on every machine and any number of threads.
#include <opencv2/core.hpp>
#include <vector>

#include "capture/camera_model.h"
#include "simulator/people/performance.h"
#include "simulator/studio/seen_figure.h"

namespace rotunda::simulator {

// A part of the picture: linear light, already multiplied by alpha; alpha is the share of the pixel covered.
struct FigureLayer {
  cv::Rect box;  // in the picture; empty if no figure is in sight
  cv::Mat rgba;  // CV_32FC4: red, green, blue, alpha
};

// Safe from any number of threads.
class FigureRenderer {
 public:
  explicit FigureRenderer(const std::vector<Figure>& figures);  // lent
  // `supersampling`: samples a pixel along each axis.
  FigureLayer draw(const capture::CameraModel& camera, const LitFigures& figures, int supersampling) const;

 private:
  const std::vector<Figure>& figures_;
  std::vector<bool> is_closed_;  // nobody sees its inside
};

// Samples an axis that give about 3000 samples across the picture: never fewer than 2.
int default_supersampling(int picture_width);

}  // namespace rotunda::simulator
