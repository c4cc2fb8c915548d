#pragma once
// A geometry image as pictures for people: what stands in the paper's figure 4.
#include <opencv2/core.hpp>

#include "recon/sphere/geometry_image.h"

namespace rotunda::recon {

// CV_8UC3, RGB: x, y, z as red, green, blue over the image's own box. (2^level + 1)^2 pixels.
cv::Mat position_picture(const GeometryImage& image);
// CV_8UC3, RGB: normals, -1 to 1 as 0 to 255.
cv::Mat normal_picture(const GeometryImage& image);
// CV_8UC3, RGB: the colours as they are, (2^colour_level + 1)^2 pixels.
cv::Mat colour_picture(const GeometryImage& image);

}  // namespace rotunda::recon
