#pragma once
// Pictures of a motion graph for people: the paper's figure 3, and how alike its frames are. CV_8UC3, RGB. Both draw
// headless: no other GL context may be current on this thread. They throw what open_character throws.
#include <filesystem>
#include <opencv2/core.hpp>

#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

// States in a row, a frame of each in its node; transitions as arrows with a frame in the middle and the price of
// their seams, forwards above, backwards below, actions on top; synthesised ones dashed.
cv::Mat graph_picture(const std::filesystem::path& character, const recon::MotionGraph& graph);

// Every frame of every clip against every other: dark is alike, rings are seams.
cv::Mat similarity_sheet(const std::filesystem::path& character, const recon::MotionGraph& graph);

// A transition as the paper's figure 5: what is seen from before it begins until after it has ended, side by side.
// `path`: states and actions in the order to be gone through, such as walk, idle, walk.
cv::Mat transition_strip(const std::filesystem::path& character, const recon::MotionGraph& graph,
                         const std::vector<std::string>& path, int pictures = 12);

}  // namespace rotunda::playback
