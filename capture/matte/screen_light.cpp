#include "capture/matte/screen_light.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "capture/srgb.h"

namespace rotunda::capture {
namespace {

constexpr float kLeadNeeded = 1.17F;  // as backdrop_plate.cpp: blue paint leads by a third and more
constexpr int kLeastLevel = 12;       // below it no hue can be told from noise

}  // namespace

int own_channel(Backdrop backdrop) {
  return backdrop == Backdrop::blue ? 2 : 1;
}

cv::Mat screen_mask(const cv::Mat& rgb, Backdrop backdrop, const cv::Mat& alpha) {
  const int own = own_channel(backdrop);
  cv::Mat mask(rgb.size(), CV_8UC1), wide;
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const auto& p = rgb.at<cv::Vec3b>(y, x);
      const int others = std::max(p[(own + 1) % 3], p[(own + 2) % 3]);
      mask.at<std::uint8_t>(y, x) =
          p[own] >= kLeastLevel && static_cast<float>(p[own]) >= kLeadNeeded * static_cast<float>(others) ? 255 : 0;
    }
  cv::medianBlur(mask, mask, 5);
  if (alpha.empty()) return mask;
  cv::dilate(alpha >= 8, wide, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  mask.setTo(0, wide);
  return mask;
}

cv::Mat own_light(const cv::Mat& rgb, int own) {
  cv::Mat codes, light;
  cv::extractChannel(rgb, codes, own);
  cv::LUT(codes, cv::Mat(1, 256, CV_32FC1, const_cast<float*>(linear_table().data())), light);
  return light;
}

double saturation_at(const cv::Vec3b& pixel, int own) {
  const auto& table = linear_table();
  const float others = std::max(table[pixel[(own + 1) % 3]], table[pixel[(own + 2) % 3]]);
  return 1.0 - others / std::max(1e-4F, table[pixel[own]]);
}

}  // namespace rotunda::capture
