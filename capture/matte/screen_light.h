#pragma once
// What of a picture is screen, and how much of the screen's light and colour each of its pixels has.
#include <opencv2/core.hpp>

#include "capture/matte/backdrop_plate.h"

namespace rotunda::capture {

inline constexpr int kScreenClipped = 254;  // grey levels
// Linear; a channel lead of 1.17 in codes, which makes a pixel screen, is 0.3.
inline constexpr double kWeakSaturation = 0.35;

int own_channel(Backdrop backdrop);

// CV_8UC1, 255 where a pixel of `rgb` (CV_8UC3) is of the backdrop's hue and not of the performer, nor of the pixels
// about the outline, which mix both; specks and holes of a few pixels smoothed away. `alpha`: the performer's matte,
// or empty.
cv::Mat screen_mask(const cv::Mat& rgb, Backdrop backdrop, const cv::Mat& alpha);

cv::Mat own_light(const cv::Mat& rgb, int own);         // CV_32FC1, linear, 0 to 1
double saturation_at(const cv::Vec3b& pixel, int own);  // 1 - the larger other channel / the backdrop's, linear light

}  // namespace rotunda::capture
