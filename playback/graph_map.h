#pragma once
// A motion graph as small as a stamp: where the character is in it and where it goes. No GL.
#include <opencv2/core.hpp>
#include <string>

#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

// CV_8UC4, RGBA with straight alpha, about 220 pixels a side. States on a circle, transitions between them (synthesised
// ones dashed), actions as loops; `doing` (a state, transition or action) is bright, the state `wanted` is ringed.
cv::Mat graph_map(const recon::MotionGraph& graph, const std::string& doing, const std::string& wanted);

}  // namespace rotunda::playback
