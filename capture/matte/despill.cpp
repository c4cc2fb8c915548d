#include "capture/matte/despill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kReach = 4;             // pixels beyond the outline that get colours
constexpr int kWindow = 9;            // pixels, odd: where the two colours about a pixel are looked at
constexpr float kRim = 4.0F;          // pixels: how far in lens, demosaicing and grazing light carry the spill
constexpr int kCloth = 21;            // pixels, odd: where the cloth inside of the rim is looked at
constexpr float kNoise = 3.0F;        // grey levels: of a pixel against its mixture
constexpr double kSharpening = 1.5;   // the matte is smoothed, the picture is not
constexpr float kAlphaError = 0.08F;  // of the matte

// Mean of the masked pixels about each pixel, CV_32FC3, and their share in the window, CV_32FC1.
struct LocalMean {
  cv::Mat colour, share;
};
LocalMean local_mean(const cv::Mat& picture, const cv::Mat& mask, int window) {
  LocalMean mean;
  cv::Mat masked = cv::Mat::zeros(picture.size(), CV_32FC3);
  picture.copyTo(masked, mask);
  mask.convertTo(mean.share, CV_32F, 1.0 / 255.0);
  cv::boxFilter(masked, mean.colour, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::boxFilter(mean.share, mean.share, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      mean.colour.at<cv::Vec3f>(y, x) *= 1.0F / std::max(1e-6F, mean.share.at<float>(y, x));
  return mean;
}

// The likeliest colour of the performer in a pixel that is `alpha` of it: between what solving the mixture gives, which
// errs the more the less of it is there, and the mean of the performer close by, which knows no texture.
cv::Vec3f unmixed(const cv::Vec3f& pixel, float alpha, const cv::Vec3f& inside, const cv::Vec3f& outside) {
  cv::Vec3f result;
  const cv::Vec3f contrast = inside - outside;
  constexpr float kTexture = 25.0F;  // grey levels: what cloth differs from its mean
  for (int c = 0; c < 3; ++c) {
    const float off = pixel[c] - alpha * inside[c] - (1.0F - alpha) * outside[c];
    const float error = kNoise * kNoise + kAlphaError * kAlphaError * contrast[c] * contrast[c];
    const float gain = alpha * kTexture * kTexture / (alpha * alpha * kTexture * kTexture + error);
    result[c] = inside[c] + std::min(gain, 1.0F / std::max(alpha, 0.3F)) * off;
  }
  return result;
}

// By how much the backdrop's channel leads the other two; 0 if it does not.
float lead_of(const cv::Vec3f& colour, int own) {
  const float other = std::max(colour[own == 0 ? 1 : 0], colour[own == 2 ? 1 : 2]);
  return std::max(0.0F, colour[own] - other);
}

void take_out_mixture(cv::Mat& colours, const cv::Mat& soft, const cv::Mat& near) {
  cv::Mat alpha;
  soft.convertTo(alpha, CV_8U, kSharpening, 127.5 * (1.0 - kSharpening));
  const cv::Mat all_in = alpha >= 250, all_out = alpha <= 5;
  cv::Mat sure_in, sure_out;
  cv::erode(all_in, sure_in, cv::Mat::ones(3, 3, CV_8UC1));
  cv::erode(all_out, sure_out, cv::Mat::ones(3, 3, CV_8UC1));
  const auto inside = local_mean(colours, sure_in, kWindow), outside = local_mean(colours, sure_out, kWindow);
  for (int y = 0; y < colours.rows; ++y)
    for (int x = 0; x < colours.cols; ++x) {
      if (near.at<std::uint8_t>(y, x) == 0 || all_in.at<std::uint8_t>(y, x) != 0) continue;
      // Too thin to have an inside, or a gap between limbs: nothing is known of one of the two colours.
      if (inside.share.at<float>(y, x) < 1e-4F || outside.share.at<float>(y, x) < 1e-4F) continue;
      const float a = static_cast<float>(alpha.at<std::uint8_t>(y, x)) / 255.0F;
      auto& pixel = colours.at<cv::Vec3f>(y, x);
      pixel = unmixed(pixel, a, inside.colour.at<cv::Vec3f>(y, x), outside.colour.at<cv::Vec3f>(y, x));
    }
}

void take_out_light(cv::Mat& colours, const cv::Mat& depth, const cv::Mat& near, int own) {
  cv::Mat lead(colours.size(), CV_32FC3);
  std::transform(colours.begin<cv::Vec3f>(), colours.end<cv::Vec3f>(), lead.begin<cv::Vec3f>(),
                 [own](const cv::Vec3f& colour) { return cv::Vec3f(lead_of(colour, own), 0.0F, 0.0F); });
  const auto allowed = local_mean(lead, depth > kRim, kCloth);
  for (int y = 0; y < colours.rows; ++y)
    for (int x = 0; x < colours.cols; ++x) {
      const float in = depth.at<float>(y, x);
      if (in > 2.0F * kRim || near.at<std::uint8_t>(y, x) == 0) continue;
      const float excess = lead.at<cv::Vec3f>(y, x)[0] - allowed.colour.at<cv::Vec3f>(y, x)[0];
      const float trust = std::clamp((2.0F * kRim - in) / kRim, 0.0F, 1.0F);  // fades out a rim's width further in
      if (excess > 0.0F) colours.at<cv::Vec3f>(y, x)[own] -= trust * excess;
    }
}

}  // namespace

cv::Mat despilled(const cv::Mat& rgb, const Matte& matte, Backdrop backdrop) {
  if (rgb.type() != CV_8UC3 || matte.alpha.size() != rgb.size() || matte.alpha.type() != CV_8UC1)
    throw InvalidInput("taking out spill wants a picture of 8-bit red, green, blue and a matte of its size");
  cv::Mat result = rgb.clone();
  const cv::Rect box = cv::boundingRect(matte.alpha);
  if (box.empty()) return result;
  constexpr int kMargin = kReach + kCloth;
  const cv::Rect around =
      cv::Rect(box.x - kMargin, box.y - kMargin, box.width + 2 * kMargin, box.height + 2 * kMargin) &
      cv::Rect({}, rgb.size());
  const cv::Mat alpha = matte.alpha(around);
  cv::Mat colours, depth, near, framed;
  rgb(around).convertTo(colours, CV_32F);
  cv::dilate(alpha >= 128, near, cv::Mat::ones(2 * kReach + 1, 2 * kReach + 1, CV_8UC1));
  // The picture's border is no outline.
  cv::copyMakeBorder(alpha >= 128, framed, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  cv::distanceTransform(framed, depth, cv::DIST_L2, 3, CV_32F);
  depth = depth(cv::Rect(1, 1, alpha.cols, alpha.rows)).clone();
  take_out_mixture(colours, alpha, near);
  take_out_light(colours, depth, near, backdrop == Backdrop::blue ? 2 : 1);
  cv::Mat bytes;
  colours.convertTo(bytes, CV_8U);
  bytes.copyTo(result(around), near);
  return result;
}

}  // namespace rotunda::capture
