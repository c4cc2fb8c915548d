#include "recon/colour/spill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rotunda::recon {
namespace {

constexpr float kRim = 4.0F;  // pixels: how far in from the outline lens, demosaicing and grazing light carry the spill
constexpr int kWindow = 21;   // pixels, odd: where the cloth inside is looked at
constexpr float kMixed = 2.0F;  // pixels from the outline that hold backdrop too
constexpr int kReach = 4;       // pixels: how far colours are carried outwards

// By how much the backdrop's channel leads the other two; 0 if it does not.
cv::Mat lead_of(const cv::Mat& rgb, int own) {
  cv::Mat channel[3], most, lead;
  cv::split(rgb, channel);
  cv::max(channel[own == 0 ? 1 : 0], channel[own == 2 ? 1 : 2], most);
  cv::subtract(channel[own], most, lead);  // saturates at 0
  return lead;
}

// The mean lead of the cloth well inside the outline, around each pixel; 0 where there is none near.
cv::Mat lead_inside(const cv::Mat& lead, const cv::Mat& depth_in_matte) {
  cv::Mat deep = depth_in_matte > kRim, share, mean;
  deep.convertTo(share, CV_32F, 1.0 / 255.0);
  lead.convertTo(mean, CV_32F);
  mean = mean.mul(share);
  cv::boxFilter(mean, mean, CV_32F, {kWindow, kWindow});
  cv::boxFilter(share, share, CV_32F, {kWindow, kWindow});
  return mean / cv::max(share, 1e-3F);
}

}  // namespace

cv::Mat without_spill(const cv::Mat& rgb, const cv::Mat& depth_in_matte, capture::Backdrop backdrop) {
  const int own = backdrop == capture::Backdrop::blue ? 2 : 1;
  const cv::Mat lead = lead_of(rgb, own), allowed = lead_inside(lead, depth_in_matte);
  cv::Mat result = rgb.clone();
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const float depth = depth_in_matte.at<float>(y, x);
      if (depth <= 0.0F || depth > 2.0F * kRim) continue;
      const float excess = static_cast<float>(lead.at<std::uint8_t>(y, x)) - allowed.at<float>(y, x);
      const float trust = std::clamp((2.0F * kRim - depth) / kRim, 0.0F, 1.0F);  // fades out a rim's width further in
      if (excess > 0.0F)
        result.at<cv::Vec3b>(y, x)[own] =
            cv::saturate_cast<std::uint8_t>(static_cast<float>(rgb.at<cv::Vec3b>(y, x)[own]) - trust * excess);
    }
  return result;
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
