#include "tests/bench/picture_score.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rotunda::bench {
namespace {

cv::Mat windowed(const cv::Mat& picture) {
  cv::Mat mean;
  cv::GaussianBlur(picture, mean, {11, 11}, 1.5);
  return mean;
}

}  // namespace

double psnr(const cv::Mat& a, const cv::Mat& b) {
  const double rms = cv::norm(a, b, cv::NORM_L2) / std::sqrt(3.0 * static_cast<double>(a.total()));
  return rms > 0.0 ? 20.0 * std::log10(255.0 / rms) : 99.0;
}

double ssim(const cv::Mat& a, const cv::Mat& b) {
  const double c1 = std::pow(0.01 * 255.0, 2), c2 = std::pow(0.03 * 255.0, 2);
  cv::Mat x, y;
  a.convertTo(x, CV_32F);
  b.convertTo(y, CV_32F);
  const cv::Mat mx = windowed(x), my = windowed(y);
  const cv::Mat vx = windowed(x.mul(x)) - mx.mul(mx), vy = windowed(y.mul(y)) - my.mul(my);
  const cv::Mat vxy = windowed(x.mul(y)) - mx.mul(my);
  const cv::Scalar one = cv::Scalar::all(c1), two = cv::Scalar::all(c2);
  const cv::Mat above = (2.0 * mx.mul(my) + one).mul(2.0 * vxy + two);
  const cv::Mat below = (mx.mul(mx) + my.mul(my) + one).mul(vx + vy + two);
  const cv::Scalar mean = cv::mean(above / below);
  return (mean[0] + mean[1] + mean[2]) / 3.0;
}

}  // namespace rotunda::bench
