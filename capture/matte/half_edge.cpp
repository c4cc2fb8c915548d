#include "capture/matte/half_edge.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

constexpr int kNear = 2, kFar = 5;        // half sides of the windows that colours are averaged in, half-size pixels
constexpr int kMargin = kFar + 2;         // of the box about the performer
constexpr float kHalfCoverage = 0.45F;    // of grey levels: light is mixed before the curve is laid on it
constexpr float kLeastContrast = 144.0F;  // grey levels squared: below it two colours tell nothing

// Red, green, blue in grey levels where `mask` says, with 1 in the fourth channel; else all 0.
cv::Mat masked(const HalfPicture& half, const cv::Rect& box, const cv::Mat& mask) {
  cv::Mat result(box.size(), CV_8UC4);
  for (int y = 0; y < box.height; ++y) {
    const std::uint16_t* plane[3];
    for (std::size_t c = 0; c < 3; ++c) plane[c] = half.planes[c].ptr<std::uint16_t>(box.y + y) + box.x;
    const auto* take = mask.ptr<std::uint8_t>(y);
    auto* out = result.ptr<cv::Vec4b>(y);
    for (int x = 0; x < box.width; ++x) {
      const auto level = [&](const std::uint16_t* values) {
        return static_cast<std::uint8_t>((values[x] / kHalfScale) & take[x]);
      };
      out[x] = {level(plane[0]), level(plane[1]), level(plane[2]), static_cast<std::uint8_t>(take[x] & 1U)};
    }
  }
  return result;
}

// Mean colours over the masked pixels in a window about each pixel.
class LocalColour {
 public:
  LocalColour(const HalfPicture& half, const cv::Rect& box, const cv::Mat& mask) : pixels_(masked(half, box, mask)) {
    cv::boxFilter(pixels_, sums_, CV_16U, {2 * kNear + 1, 2 * kNear + 1}, {-1, -1}, false, cv::BORDER_CONSTANT);
  }
  // False if none is anywhere near.
  bool at(int x, int y, cv::Vec3f& colour) const {
    cv::Vec4i sum = sums_.at<cv::Vec<std::uint16_t, 4>>(y, x);
    if (sum[3] == 0) sum = far_sum(x, y);
    if (sum[3] == 0) return false;
    const float scale = 1.0F / static_cast<float>(sum[3]);
    colour = {static_cast<float>(sum[0]) * scale, static_cast<float>(sum[1]) * scale,
              static_cast<float>(sum[2]) * scale};
    return true;
  }

 private:
  cv::Vec4i far_sum(int x, int y) const {
    cv::Vec4i sum(0, 0, 0, 0);
    for (int j = std::max(0, y - kFar); j <= std::min(pixels_.rows - 1, y + kFar); ++j)
      for (int i = std::max(0, x - kFar); i <= std::min(pixels_.cols - 1, x + kFar); ++i)
        sum += cv::Vec4i(pixels_.at<cv::Vec4b>(j, i));
    return sum;
  }
  cv::Mat pixels_, sums_;
};

std::uint8_t unbiased(float alpha) {
  const float a = alpha < kHalfCoverage ? 0.5F * alpha / kHalfCoverage
                                        : 0.5F + 0.5F * (alpha - kHalfCoverage) / (1.0F - kHalfCoverage);
  return cv::saturate_cast<std::uint8_t>(255.0F * a);
}

}  // namespace

cv::Rect half_edge_box(const cv::Rect& box, cv::Size within) {
  return cv::Rect(box.x - kMargin, box.y - kMargin, box.width + 2 * kMargin, box.height + 2 * kMargin) &
         cv::Rect({}, within);
}

cv::Mat half_edge_matte(const HalfPicture& half, const cv::Mat& inside, const cv::Rect& around) {
  const cv::Mat rough = inside(around), square = cv::Mat::ones(3, 3, CV_8UC1);
  cv::Mat sure_inside, reach;
  cv::erode(rough, sure_inside, square);
  cv::dilate(rough, reach, square);
  const LocalColour foreground(half, around, sure_inside), backdrop(half, around, 255 - reach);
  cv::Mat alpha = rough.clone();
  for (int y = 0; y < around.height; ++y) {
    const auto *outer = reach.ptr<std::uint8_t>(y), *inner = sure_inside.ptr<std::uint8_t>(y);
    for (int x = 0; x < around.width; ++x) {
      if (outer[x] == inner[x]) continue;
      cv::Vec3f f, b;
      if (!foreground.at(x, y, f) || !backdrop.at(x, y, b)) continue;
      const cv::Vec3f way = f - b;
      const float length = way.dot(way);
      if (length < kLeastContrast) continue;
      cv::Vec3f pixel;
      for (std::size_t c = 0; c < 3; ++c)
        pixel[static_cast<int>(c)] =
            static_cast<float>(half.planes[c].at<std::uint16_t>(around.y + y, around.x + x)) / kHalfScale;
      alpha.at<std::uint8_t>(y, x) = unbiased(std::clamp((pixel - b).dot(way) / length, 0.0F, 1.0F));
    }
  }
  return alpha;
}

}  // namespace rotunda::capture
