#pragma once
// The plate: what the backdrop alone would look like in a picture. From a clean plate (a picture of the empty studio),
// or fitted to the picture itself: a smooth surface through its backdrop-coloured pixels.
#include <opencv2/core.hpp>
#include <optional>

#include "capture/matte/key_limit.h"

namespace rotunda::capture {

enum class Backdrop { blue, green };

// The one whose colour leads in more of the picture (CV_8UC3, RGB); nothing where neither leads in a fiftieth of it.
std::optional<Backdrop> backdrop_of(const cv::Mat& rgb);
// Whether the performer stands before the backdrop's screen: it takes up most of the plate (CV_8UC3, RGB) where `stage`
// (stage_mask.h, of the plate's size; empty: anywhere) is. Told by means over 8 x 8 pixels: the noise of a dark floor
// leads in any colour somewhere.
bool is_before_screen(const cv::Mat& plate, Backdrop backdrop, const cv::Mat& stage = {});

// The channels of a plate of this backdrop, by their means.
KeyChannels key_channels(const cv::Mat& plate, Backdrop backdrop);

// The share of a picture (CV_8UC3, RGB) whose hue is the backdrop's, 0 to 1.
double backdrop_share(const cv::Mat& rgb, Backdrop backdrop);

// CV_8UC1, 255 where the picture's hue is the backdrop's.
cv::Mat backdrop_mask(const cv::Mat& rgb, Backdrop backdrop);

// ln(channel + kLogOffset) of the plate, CV_32FC3 in RGB order, as a fifth-order polynomial in x and y fitted to the
// backdrop-coloured pixels with outliers thrown out (residual above 0.25, then 0.12). Empty if they are fewer than 2 %
// of the picture: then there is no backdrop to speak of.
cv::Mat fit_plate(const cv::Mat& rgb, Backdrop backdrop);

// The same as a picture, CV_8UC3; empty likewise.
cv::Mat fit_plate_picture(const cv::Mat& rgb, Backdrop backdrop);

// Keeps logarithms of dark pixels from following the sensor's noise; grey levels.
constexpr float kLogOffset = 3.0F;
// ln(channel + kLogOffset) of a picture, CV_32FC3, and back to CV_8UC3.
cv::Mat log_picture(const cv::Mat& rgb);
cv::Mat picture_of_log(const cv::Mat& logs);

// By how much ln of each channel has changed since the plate, as lamps and sensors do while they get warm: the median
// over the pixels that show the backdrop, in light or in shadow; 0 if they are too few. Both as log_picture() has them.
cv::Scalar light_change(const cv::Mat& log_rgb, const cv::Mat& log_plate, Backdrop backdrop);

}  // namespace rotunda::capture
