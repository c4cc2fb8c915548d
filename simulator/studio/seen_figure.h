#pragma once
// A figure through one camera: where each vertex is seen when the shutter opens and closes, and in which light.
#include <Eigen/Core>
#include <opencv2/core/types.hpp>
#include <vector>

#include "capture/camera_model.h"
#include "simulator/people/performance.h"
#include "simulator/studio/material.h"

namespace rotunda::simulator {

// Figures while a shutter is open. In between vertices go straight: over 5 ms a foot in full swing is 0.3 mm off.
struct LitFigures {
  std::vector<recon::TriangleMesh> opening, closing;  // surfaces when the shutter opens and closes, one a figure
  std::vector<std::vector<ArrivingLight>> light;      // on each vertex
};

struct SeenPoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double depth = 0.0;  // metres along the axis; 0: not in sight
};

// One a vertex.
struct SeenFigure {
  std::vector<SeenPoint> opening, closing;
  std::vector<SeenLight> light;
};

// `number`: the figure's among the lit ones. `is_closed`: nobody sees its inside, so what is turned away needs no
// light.
SeenFigure see_figure(const capture::CameraModel& camera, const LitFigures& figures, std::size_t number,
                      const Figure& figure, bool is_closed);

// The part of the picture they are in, with room for the lens's blur; empty if out of sight.
cv::Rect box_of(const std::vector<SeenFigure>& seen, const capture::CameraModel& camera);

// Of a vertex while the shutter is open, pixels.
double longest_way(const std::vector<SeenFigure>& seen);

}  // namespace rotunda::simulator
