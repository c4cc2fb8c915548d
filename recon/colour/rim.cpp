#include "recon/colour/rim.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rotunda::recon {
namespace {

constexpr float kMixed = 2.0F;  // pixels from the outline that hold backdrop too
constexpr int kReach = 4;       // pixels: how far colours are carried outwards

}  // namespace

cv::Mat depth_inside(const capture::Matte& matte) {
  cv::Mat framed, depth;
  cv::copyMakeBorder(matte.alpha >= 128, framed, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  cv::distanceTransform(framed, depth, cv::DIST_L2, 3, CV_32F);
  return depth(cv::Rect(1, 1, matte.alpha.cols, matte.alpha.rows)).clone();
}

double outline_weight(double depth_inside, double feather) {
  const double s = std::clamp((depth_inside - 1.0) / std::max(1e-6, feather), 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

cv::Mat rim_from_inside(const cv::Mat& rgb, const cv::Mat& depth_in_matte) {
  cv::Mat deep = depth_in_matte > kMixed, mean(rgb.size(), CV_8UC3, cv::Scalar::all(0)), share;
  deep.convertTo(share, CV_32F, 1.0 / 255.0);
  rgb.copyTo(mean, deep);
  mean.convertTo(mean, CV_32F);
  const cv::Size window(2 * kReach + 1, 2 * kReach + 1);
  cv::GaussianBlur(mean, mean, window, kReach / 2.0);
  cv::GaussianBlur(share, share, window, kReach / 2.0);
  cv::Mat result = rgb.clone();
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const float near = share.at<float>(y, x);
      if (deep.at<std::uint8_t>(y, x) == 0 && near > 1e-3F)
        result.at<cv::Vec3b>(y, x) = cv::Vec3b(mean.at<cv::Vec3f>(y, x) * (1.0F / near));
    }
  return result;
}

}  // namespace rotunda::recon
