#include "capture/matte/despill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kReach = 4;             // pixels beyond the outline that get colours
constexpr int kWindow = 7;            // pixels, odd: where the two colours about a pixel are looked at
constexpr float kRim = 4.0F;          // pixels: how far in lens, demosaicing and grazing light carry the spill
constexpr int kCloth = 21;            // pixels, odd: where the cloth inside of the rim is looked at
constexpr float kNoise = 6.0F;        // grey levels: of a pixel against its mixture
constexpr double kSharpening = 1.9;   // undoes the matte's 0.8 px on an edge of lens, 0.4, and photosite, 0.3
constexpr float kAlphaError = 0.08F;  // of the matte
constexpr float kSiteScale = 257.0F;  // of mosaic_of(), against grey levels

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

// What the sensor's curve makes of a mixture: lens and photosite mix light, and mid-way between dark and bright that is
// far brighter than the mean of the two values. Grey levels in and out.
struct MixedValue {
  float value;         // of alpha * inside + (1 - alpha) * outside in linear light
  float by_performer;  // d value / d inside
  float by_alpha;      // d value / d alpha
};

float linear_at(float level) {
  return static_cast<float>(linear_of_srgb(std::clamp(level, 0.0F, 255.0F) / 255.0));
}

// Slope of the curve where both are `level` and `linear`, linear light by grey level.
float slope_at(float level, float linear) {
  const float srgb = std::clamp(level, 0.0F, 255.0F) / 255.0F;
  return (srgb <= 0.04045F ? 1.0F / 12.92F : 2.4F * linear / (srgb + 0.055F)) / 255.0F;
}

MixedValue mixed_value(float alpha, float inside, float outside) {
  const float in = linear_at(inside), out = linear_at(outside), mixed = alpha * in + (1.0F - alpha) * out;
  const float value = 255.0F * static_cast<float>(srgb_of_linear(mixed)), slope = slope_at(value, mixed);
  return {value, alpha * slope_at(inside, in) / slope, (in - out) / slope};
}

// The likeliest value of the performer in a photosite that is `alpha` of it: between what solving the mixture gives,
// which errs the more the less of it is there, and the mean of the performer close by, which knows no texture. One
// step of a Kalman filter, the mixture made linear about that mean.
float unmixed(float value, float alpha, float inside, float outside) {
  constexpr float kTexture = 20.0F;  // grey levels: what cloth differs from its mean
  const auto [expected, slope, by_alpha] = mixed_value(alpha, inside, outside);
  const float error = kNoise * kNoise + kAlphaError * kAlphaError * by_alpha * by_alpha;
  const float gain = slope * kTexture * kTexture / (slope * slope * kTexture * kTexture + error);
  return inside + std::min(gain, 1.0F / std::max(slope, 0.3F)) * (value - expected);
}

// By how much the backdrop's channel leads the other two; 0 if it does not.
float lead_of(const cv::Vec3f& colour, int own) {
  const float other = std::max(colour[own == 0 ? 1 : 0], colour[own == 2 ? 1 : 2]);
  return std::max(0.0F, colour[own] - other);
}

// What each pixel of a picture is a mixture of.
struct Mixtures {
  cv::Mat alpha;  // CV_8UC1
  cv::Mat mixed;  // CV_8UC1, 255 where both colours are in it, or backdrop alone, and both are known
  LocalMean inside, outside;
};

Mixtures mixtures_of(const cv::Mat& colours, const cv::Mat& soft, const cv::Mat& near) {
  Mixtures found;
  soft.convertTo(found.alpha, CV_8U, kSharpening, 127.5 * (1.0 - kSharpening));
  const cv::Mat all_in = found.alpha >= 250, all_out = found.alpha <= 5;
  cv::Mat sure_in, sure_out;
  cv::erode(all_in, sure_in, cv::Mat::ones(3, 3, CV_8UC1));
  cv::erode(all_out, sure_out, cv::Mat::ones(3, 3, CV_8UC1));
  found.inside = local_mean(colours, sure_in, kWindow);
  found.outside = local_mean(colours, sure_out, kWindow);
  // Too thin to have an inside, or a gap between limbs: nothing is known of one of the two colours.
  found.mixed = near & ~all_in & (found.inside.share >= 1e-4F) & (found.outside.share >= 1e-4F);
  return found;
}

void take_out_mixture(cv::Mat& colours, const Mixtures& mixtures) {
  for (int y = 0; y < colours.rows; ++y)
    for (int x = 0; x < colours.cols; ++x) {
      if (mixtures.mixed.at<std::uint8_t>(y, x) == 0) continue;
      const float alpha = static_cast<float>(mixtures.alpha.at<std::uint8_t>(y, x)) / 255.0F;
      const auto &in = mixtures.inside.colour.at<cv::Vec3f>(y, x), &out = mixtures.outside.colour.at<cv::Vec3f>(y, x);
      auto& pixel = colours.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) pixel[c] = unmixed(pixel[c], alpha, in[c], out[c]);
    }
}

// The colour of a mosaic's photosite.
int channel_of(BayerOrder order, int x, int y) {
  const bool red_right = order == BayerOrder::gr || order == BayerOrder::bg;
  const bool red_below = order == BayerOrder::gb || order == BayerOrder::bg;
  const bool in_red_column = (x % 2 == 1) == red_right, in_red_row = (y % 2 == 1) == red_below;
  return in_red_column != in_red_row ? 1 : in_red_row ? 0 : 2;
}

// `sites`: CV_16UC1 as mosaic_of() has them, beginning at an even row and column of the mosaic.
void take_out_mixture(cv::Mat& sites, BayerOrder order, const Mixtures& mixtures) {
  for (int y = 0; y < sites.rows; ++y)
    for (int x = 0; x < sites.cols; ++x) {
      if (mixtures.mixed.at<std::uint8_t>(y, x) == 0) continue;
      const int c = channel_of(order, x, y);
      auto& site = sites.at<std::uint16_t>(y, x);
      const float found = unmixed(
          static_cast<float>(site) / kSiteScale, static_cast<float>(mixtures.alpha.at<std::uint8_t>(y, x)) / 255.0F,
          mixtures.inside.colour.at<cv::Vec3f>(y, x)[c], mixtures.outside.colour.at<cv::Vec3f>(y, x)[c]);
      site = cv::saturate_cast<std::uint16_t>(found * kSiteScale);
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

// What of a picture is looked at.
struct Rim {
  cv::Rect box;  // begins at an even row and column
  cv::Mat alpha, near, depth;
};

Rim rim_of(const Matte& matte) {
  Rim rim;
  const cv::Rect box = cv::boundingRect(matte.alpha);
  if (box.empty()) return rim;
  constexpr int kMargin = kReach + kCloth;
  const cv::Point first(std::max(0, box.x - kMargin) & ~1, std::max(0, box.y - kMargin) & ~1);
  rim.box = cv::Rect(first, box.br() + cv::Point(kMargin, kMargin)) & cv::Rect({}, matte.alpha.size());
  rim.alpha = matte.alpha(rim.box);
  cv::dilate(rim.alpha >= 128, rim.near, cv::Mat::ones(2 * kReach + 1, 2 * kReach + 1, CV_8UC1));
  cv::Mat framed, depth;  // the picture's border is no outline
  cv::copyMakeBorder(rim.alpha >= 128, framed, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  cv::distanceTransform(framed, depth, cv::DIST_L2, 3, CV_32F);
  rim.depth = depth(cv::Rect(1, 1, rim.alpha.cols, rim.alpha.rows)).clone();
  return rim;
}

// `colours`: CV_32FC3 of the rim's box, without the mixture.
void finish(cv::Mat& result, const Rim& rim, cv::Mat& colours, Backdrop backdrop) {
  take_out_light(colours, rim.depth, rim.near, backdrop == Backdrop::blue ? 2 : 1);
  cv::Mat bytes;
  colours.convertTo(bytes, CV_8U);
  bytes.copyTo(result(rim.box), rim.near);
}

}  // namespace

cv::Mat despilled(const cv::Mat& rgb, const Matte& matte, Backdrop backdrop) {
  if (rgb.type() != CV_8UC3 || matte.alpha.size() != rgb.size() || matte.alpha.type() != CV_8UC1)
    throw InvalidInput("taking out spill wants a picture of 8-bit red, green, blue and a matte of its size");
  cv::Mat result = rgb.clone(), colours;
  const Rim rim = rim_of(matte);
  if (rim.box.empty()) return result;
  rgb(rim.box).convertTo(colours, CV_32F);
  take_out_mixture(colours, mixtures_of(colours, rim.alpha, rim.near));
  finish(result, rim, colours, backdrop);
  return result;
}

cv::Mat despilled(const Image& image, const Matte& matte, Backdrop backdrop) {
  cv::Mat result = to_rgb(image), colours;
  if (!is_mosaic(image.format)) return despilled(result, matte, backdrop);
  if (matte.alpha.size() != result.size() || matte.alpha.type() != CV_8UC1)
    throw InvalidInput("taking out spill wants a matte of the image's size");
  const Rim rim = rim_of(matte);
  if (rim.box.empty()) return result;
  const auto order = layout_of(image.format).order;
  cv::Mat sites = mosaic_of(image)(rim.box).clone();
  result(rim.box).convertTo(colours, CV_32F);
  take_out_mixture(sites, order, mixtures_of(colours, rim.alpha, rim.near));
  demosaiced(sites, order).convertTo(colours, CV_32F);
  finish(result, rim, colours, backdrop);
  return result;
}

}  // namespace rotunda::capture
