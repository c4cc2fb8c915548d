#include "capture/matte/edge_matte.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

constexpr int kBand = 3;                 // pixels to either side of the rough outline
constexpr int kFirmBand = 2;             // pixels: what is nearer to a possible mixture is looked at too
constexpr int kSureDepth = 2;            // foreground colours are taken from deeper than this
constexpr int kNear = 4, kFar = 9;       // half sides of the windows that colours are averaged in
constexpr double kSmoothing = 0.8;       // sigma of alpha, pixels
constexpr float kModelVariance = 0.01F;  // of alpha: the two-colour model is never better than a tenth
constexpr float kLumaNoise = 4e-5F;      // variance, linear light (two grey levels in mid-tones)
constexpr float kChromaNoise = 9e-5F;

// Shadow on the backdrop may deepen towards the outline, as under soles. How much light it leaves of what the backdrop
// beside the band gets:
constexpr std::array<float, 9> kShades{1.0F, 0.8F, 0.64F, 0.5F, 0.4F, 0.31F, 0.24F, 0.18F, 0.12F};
// ln of the light: what it may change by even where the backdrop beside is even; then, times the spread that is there.
constexpr float kShadeSpread = 0.15F;
constexpr float kSpreadFactor = 3.0F;
constexpr float kGapSpread = 0.5F;       // in a gap that nothing beside tells of: half of the light may be gone
constexpr float kResidualNoise = 3e-4F;  // variance by linear light: two grey levels
constexpr float kDarkNoise = 2e-6F;

const std::array<float, 256>& linear_table() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float s = static_cast<float>(i) / 255.0F;
      values[i] = s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F);
    }
    return values;
  }();
  return table;
}

cv::Mat linear(const cv::Mat& rgb) {
  cv::Mat result(rgb.size(), CV_32FC3);
  const auto& table = linear_table();
  for (int y = 0; y < rgb.rows; ++y) {
    const auto* from = rgb.ptr<cv::Vec3b>(y);
    auto* to = result.ptr<cv::Vec3f>(y);
    for (int x = 0; x < rgb.cols; ++x) to[x] = {table[from[x][0]], table[from[x][1]], table[from[x][2]]};
  }
  return result;
}

float luma(const cv::Vec3f& c) {
  return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2];
}

// For each pixel luma squared, all squared, and how ln of its light differs from the plate's.
cv::Mat moments_of(const cv::Mat& picture, const cv::Mat& empty) {
  cv::Mat moments(picture.size(), CV_32FC3);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const auto &p = picture.at<cv::Vec3f>(y, x), &e = empty.at<cv::Vec3f>(y, x);
      const float l = luma(p);
      moments.at<cv::Vec3f>(y, x) = {l * l, p.dot(p), std::log((p.dot(e) + 1e-5F) / (e.dot(e) + 1e-5F))};
    }
  return moments;
}

// Sums of a picture over the pixels of a mask, in any window at once.
class MaskedSums {
 public:
  MaskedSums(const cv::Mat& picture, const cv::Mat& mask) {
    cv::Mat masked(picture.size(), CV_32FC3, cv::Scalar::all(0));
    picture.copyTo(masked, mask);
    cv::integral(masked, sums_, CV_64F);
    cv::integral(mask / 255, counts_, CV_32S);
  }
  // Number of pixels in the window; their mean in `mean` if there are any.
  int mean_around(int x, int y, int half, cv::Vec3f& mean) const {
    const int x0 = std::max(0, x - half), y0 = std::max(0, y - half);
    const int x1 = std::min(counts_.cols - 1, x + half + 1), y1 = std::min(counts_.rows - 1, y + half + 1);
    const int count =
        counts_.at<int>(y1, x1) - counts_.at<int>(y0, x1) - counts_.at<int>(y1, x0) + counts_.at<int>(y0, x0);
    if (count == 0) return 0;
    const cv::Vec3d sum = sums_.at<cv::Vec3d>(y1, x1) - sums_.at<cv::Vec3d>(y0, x1) - sums_.at<cv::Vec3d>(y1, x0) +
                          sums_.at<cv::Vec3d>(y0, x0);
    mean = sum / count;
    return count;
  }
  int mean_near(int x, int y, cv::Vec3f& mean) const {
    const int count = mean_around(x, y, kNear, mean);
    return count > 0 ? count : mean_around(x, y, kFar, mean);
  }

 private:
  cv::Mat sums_, counts_;
};

// The two colours a pixel is mixed of, in linear light.
struct Mixture {
  cv::Vec3f foreground, background;
  float luma_variance = 0.0F, chroma_variance = 0.0F;  // of the foreground
  float shade_spread = 0.0F;                           // of ln of the background's light
};

// How far the pixel stands on the way from background to foreground, by luma and by chroma, the surer one counting
// more.
float coverage(const cv::Vec3f& pixel, const Mixture& mixture, const cv::Vec3f& background) {
  const float luma_step = luma(mixture.foreground) - luma(background);
  const cv::Vec3f way = mixture.foreground - background, grey(luma_step, luma_step, luma_step);
  const cv::Vec3f chroma_way = way - grey;
  const float luma_gone = luma(pixel) - luma(background);
  const cv::Vec3f chroma_gone = pixel - background - cv::Vec3f(luma_gone, luma_gone, luma_gone);
  const float chroma_length = std::max(1e-8F, chroma_way.dot(chroma_way));
  const float luma_noise = kLumaNoise + 0.5F * mixture.luma_variance;
  const float chroma_noise = kChromaNoise + 0.5F * mixture.chroma_variance;
  const float luma_weight = 1.0F / (kModelVariance + luma_noise / std::max(1e-8F, luma_step * luma_step));
  const float chroma_weight = 1.0F / (kModelVariance + chroma_noise / chroma_length);
  const float by_luma = std::abs(luma_step) > 1e-4F ? luma_gone / luma_step : 0.5F;
  const float by_chroma = chroma_gone.dot(chroma_way) / chroma_length;
  return std::clamp((luma_weight * by_luma + chroma_weight * by_chroma) / (luma_weight + chroma_weight), 0.0F, 1.0F);
}

// The coverage under the shade that explains the pixel best: dark cloth and deep shadow are as dark, but not as blue.
float shaded_coverage(const cv::Vec3f& pixel, const Mixture& mixture) {
  float best = 0.0F, least = std::numeric_limits<float>::max();
  for (const float shade : kShades) {
    const cv::Vec3f background = shade * mixture.background;
    const float alpha = coverage(pixel, mixture, background);
    const float unlikely = std::log(shade) / mixture.shade_spread;
    float cost = unlikely * unlikely;
    if (cost >= least) break;
    const cv::Vec3f off = pixel - alpha * mixture.foreground - (1.0F - alpha) * background;
    const float cloth = alpha * alpha * (mixture.luma_variance + mixture.chroma_variance / 3.0F);
    for (int c = 0; c < 3; ++c) cost += off[c] * off[c] / (kDarkNoise + kResidualNoise * pixel[c] + cloth);
    if (cost < least) least = cost, best = alpha;
  }
  return best;
}

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

// What a pixel may be mixed of: colours from about it.
class Surroundings {
 public:
  Surroundings(const cv::Mat& picture, const cv::Mat& empty, const cv::Mat& sure_inside, const cv::Mat& sure_outside)
      : Surroundings(picture, empty, moments_of(picture, empty), sure_inside, sure_outside) {}

  // False where no performer is near. In narrow gaps between limbs no backdrop is sure: there it is the plate's.
  bool at(int x, int y, Mixture& mixture) const {
    cv::Vec3f seen, expected, inner, outer;
    auto& f = mixture.foreground;
    if (foreground_.mean_near(x, y, f) == 0) return false;
    foreground_moments_.mean_near(x, y, inner);
    mixture.background = empty_.at<cv::Vec3f>(y, x);
    mixture.shade_spread = kGapSpread;
    if (backdrop_.mean_near(x, y, seen) > 0) {  // the plate here, as bright as the shadow beside leaves it
      plates_.mean_near(x, y, expected);
      shades_.mean_near(x, y, outer);
      for (int c = 0; c < 3; ++c) mixture.background[c] *= seen[c] / std::max(1e-4F, expected[c]);
      mixture.shade_spread = kShadeSpread + kSpreadFactor * std::sqrt(std::max(0.0F, outer[1] - outer[0] * outer[0]));
    }
    mixture.luma_variance = std::max(0.0F, inner[0] - luma(f) * luma(f));
    mixture.chroma_variance = std::max(0.0F, inner[1] - f.dot(f) - 3.0F * mixture.luma_variance);
    return true;
  }

 private:
  Surroundings(const cv::Mat& picture, const cv::Mat& empty, const cv::Mat& moments, const cv::Mat& sure_inside,
               const cv::Mat& sure_outside)
      : empty_(empty),
        foreground_(picture, sure_inside),
        foreground_moments_(moments, sure_inside),
        backdrop_(picture, sure_outside),
        plates_(empty, sure_outside),
        shades_(squared_shades(moments), sure_outside) {}

  // ln of the light against the plate's, and its square.
  static cv::Mat squared_shades(const cv::Mat& moments) {
    cv::Mat shades(moments.size(), CV_32FC3);
    std::transform(moments.begin<cv::Vec3f>(), moments.end<cv::Vec3f>(), shades.begin<cv::Vec3f>(),
                   [](const cv::Vec3f& m) { return cv::Vec3f(m[2], m[2] * m[2], 0.0F); });
    return shades;
  }

  const cv::Mat& empty_;
  MaskedSums foreground_, foreground_moments_, backdrop_, plates_, shades_;
};

// Alpha, 0 to 1, before smoothing.
cv::Mat band_alpha(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& inside, const cv::Mat& firm) {
  cv::Mat sure_inside, deep, firmly_inside, reach;
  cv::erode(inside, sure_inside, disc(kSureDepth));
  cv::erode(inside, deep, disc(kBand));
  cv::erode(firm, firmly_inside, disc(kFirmBand));
  cv::dilate(inside, reach, disc(kBand));
  const cv::Mat band = reach & ~(deep & firmly_inside);
  const cv::Mat picture = linear(rgb), empty = linear(plate);
  const Surroundings surroundings(picture, empty, sure_inside & firm, 255 - reach);

  cv::Mat alpha;
  inside.convertTo(alpha, CV_32F, 1.0 / 255.0);
  Mixture mixture;
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      if (band.at<std::uint8_t>(y, x) && surroundings.at(x, y, mixture))
        alpha.at<float>(y, x) = shaded_coverage(picture.at<cv::Vec3f>(y, x), mixture);
  return alpha;
}

}  // namespace

Matte edge_matte(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& inside, const cv::Mat& firm) {
  Matte matte{cv::Mat::zeros(rgb.size(), CV_8UC1)};
  cv::Rect around = cv::boundingRect(inside);
  if (around.empty()) return matte;
  constexpr int kMargin = kBand + kFar + 2;  // what the windows of the band's outermost pixels reach
  around = cv::Rect(around.x - kMargin, around.y - kMargin, around.width + 2 * kMargin, around.height + 2 * kMargin) &
           cv::Rect({}, rgb.size());
  cv::Mat alpha = band_alpha(rgb(around), plate(around), inside(around), firm(around));
  cv::GaussianBlur(alpha, alpha, {5, 5}, kSmoothing);
  cv::Mat out = matte.alpha(around);
  alpha.convertTo(out, CV_8U, 255.0);
  return matte;
}

}  // namespace rotunda::capture
