#pragma once
// The silhouette as a signed distance in the image, in pixels, positive inside. Near the outline it is the exact
// distance to the matte's 127.5 contour (marching squares, linear between pixels), so it is sub-pixel and unbiased;
// farther than `kExactBand` it is the distance to the nearest pixel centre of the other side, less half a pixel, and
// more than 32 pixels outside of the box around all that is inside it is no more than that. The picture's border is no
// outline: a body cut by the frame stays positive up to it.
#include <opencv2/core.hpp>

#include "capture/matte/matte.h"

namespace rotunda::recon {

inline constexpr int kExactBand = 5;  // pixels around the outline with exact distances

// CV_32FC1 of the matte's size. Throws InvalidInput unless the matte is a non-empty CV_8UC1.
cv::Mat signed_silhouette(const capture::Matte& matte);

// The same of a small picture in a fifth of the time: exact within two pixels of the outline, farther out by OpenCV's 5 x
// 5 chamfer, which is right to 2 %.
cv::Mat quick_silhouette(const capture::Matte& matte);

// True if no pixel of the matte reaches 127.5.
bool is_empty(const capture::Matte& matte);

}  // namespace rotunda::recon
