#pragma once
// Pictures of a reconstructed take as the paper's figures 1, 2 and 4 lay them out (Starck, Miller, Hilton 2005).
// CV_8UC3, RGB. They draw headless: no other GL context may be current on this thread. Throw InvalidInput for a take or
// a frame that is not reconstructed, and what reading the take does.
#include <filesystem>
#include <opencv2/core.hpp>

#include "playback/contact_sheet.h"

namespace rotunda::playback {

// Figure 1, one frame through the stages: a camera's picture and matte, the surface, the surface on the sphere (colours
// tell normals, alike on both), the geometry image's positions and colours, the surface drawn from it.
cv::Mat figure_of_stages(const std::filesystem::path& take, const ContactSheetOptions& options = {});

// Figure 2: the frame, the fifth and the tenth after it (nearer ones of a take that ends before), their positions and
// colours as geometry images; above by each frame's own map, below aligned, so that a texel is one point of the body.
// Throws InvalidInput for a take whose frames are not aligned.
cv::Mat figure_of_alignment(const std::filesystem::path& take, const ContactSheetOptions& options = {});

// Figure 4: positions quantised at 1 cm, 24 bits a texel, as paper mode stores them; not quantised; not quantised and
// in the colours of the cameras nearest to the view.
cv::Mat figure_of_quantisation(const std::filesystem::path& take, const ContactSheetOptions& options = {});

}  // namespace rotunda::playback
