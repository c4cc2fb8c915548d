#pragma once
// How like two pictures are.
#include <opencv2/core.hpp>

namespace rotunda::bench {

// Both CV_8UC3 of one size. Decibels over all pixels and channels; 99 if they are the same.
double psnr(const cv::Mat& a, const cv::Mat& b);

// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004): Gaussian window of 11 pixels, sigma 1.5, K1 = 0.01,
// K2 = 0.03; mean over pixels and channels.
double ssim(const cv::Mat& a, const cv::Mat& b);

}  // namespace rotunda::bench
