#include "capture/matte/edge_matte.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

constexpr int kBand = 3;            // pixels to either side of the rough outline
constexpr int kSureDepth = 2;       // foreground colours are taken from deeper than this
constexpr int kNear = 4, kFar = 9;  // half sides of the windows that colours are averaged in
constexpr double kSmoothing = 0.8;  // sigma of alpha, pixels
// The foreground is averaged inside, while the rim itself is darker and bluer: half coverage reads as this much.
constexpr float kHalfCoverage = 0.45F;
constexpr float kModelVariance = 0.01F;  // of alpha: the two-colour model is never better than a tenth
constexpr float kLumaNoise = 4e-5F;      // variance, linear light (two grey levels in mid-tones)
constexpr float kChromaNoise = 9e-5F;

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

// How far the pixel stands on the way from background to foreground, by luma and by chroma, the surer one counting
// more.
float coverage(const cv::Vec3f& pixel, const cv::Vec3f& foreground, const cv::Vec3f& background) {
  const float luma_step = luma(foreground) - luma(background);
  const cv::Vec3f way = foreground - background, grey(luma_step, luma_step, luma_step);
  const cv::Vec3f chroma_way = way - grey;
  const float luma_gone = luma(pixel) - luma(background);
  const cv::Vec3f chroma_gone = pixel - background - cv::Vec3f(luma_gone, luma_gone, luma_gone);
  const float chroma_length = std::max(1e-8F, chroma_way.dot(chroma_way));
  const float luma_weight = 1.0F / (kModelVariance + kLumaNoise / std::max(1e-8F, luma_step * luma_step));
  const float chroma_weight = 1.0F / (kModelVariance + kChromaNoise / chroma_length);
  const float by_luma = std::abs(luma_step) > 1e-4F ? luma_gone / luma_step : 0.5F;
  const float by_chroma = chroma_gone.dot(chroma_way) / chroma_length;
  return std::clamp((luma_weight * by_luma + chroma_weight * by_chroma) / (luma_weight + chroma_weight), 0.0F, 1.0F);
}

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

// Alpha, 0 to 1, before smoothing.
cv::Mat band_alpha(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& inside) {
  cv::Mat sure_inside, band_inside, band_outside, band;
  cv::erode(inside, sure_inside, disc(kSureDepth));
  cv::erode(inside, band_inside, disc(kBand));
  cv::dilate(inside, band_outside, disc(kBand));
  cv::subtract(band_outside, band_inside, band);
  const cv::Mat picture = linear(rgb), empty = linear(plate);
  const cv::Mat sure_outside = 255 - band_outside;
  const MaskedSums foreground(picture, sure_inside), backdrop(picture, sure_outside), plates(empty, sure_outside);

  cv::Mat alpha;
  inside.convertTo(alpha, CV_32F, 1.0 / 255.0);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      cv::Vec3f f, seen, expected;
      if (!band.at<std::uint8_t>(y, x)) continue;
      if (foreground.mean_near(x, y, f) == 0 || backdrop.mean_near(x, y, seen) == 0) continue;
      plates.mean_near(x, y, expected);
      cv::Vec3f b = empty.at<cv::Vec3f>(y, x);  // the plate here, as bright as the shadow beside the outline leaves it
      for (int c = 0; c < 3; ++c) b[c] *= seen[c] / std::max(1e-4F, expected[c]);
      alpha.at<float>(y, x) = coverage(picture.at<cv::Vec3f>(y, x), f, b);
    }
  return alpha;
}

std::uint8_t unbiased(float alpha) {
  const float a = alpha < kHalfCoverage ? 0.5F * alpha / kHalfCoverage
                                        : 0.5F + 0.5F * (alpha - kHalfCoverage) / (1.0F - kHalfCoverage);
  return cv::saturate_cast<std::uint8_t>(255.0F * a);
}

}  // namespace

Matte edge_matte(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& inside) {
  Matte matte{cv::Mat::zeros(rgb.size(), CV_8UC1)};
  cv::Rect around = cv::boundingRect(inside);
  if (around.empty()) return matte;
  constexpr int kMargin = kBand + kFar + 2;  // what the windows of the band's outermost pixels reach
  around = cv::Rect(around.x - kMargin, around.y - kMargin, around.width + 2 * kMargin, around.height + 2 * kMargin) &
           cv::Rect({}, rgb.size());
  cv::Mat alpha = band_alpha(rgb(around), plate(around), inside(around));
  cv::GaussianBlur(alpha, alpha, {5, 5}, kSmoothing);
  cv::Mat out = matte.alpha(around);
  std::transform(alpha.begin<float>(), alpha.end<float>(), out.begin<std::uint8_t>(), unbiased);
  return matte;
}

}  // namespace rotunda::capture
