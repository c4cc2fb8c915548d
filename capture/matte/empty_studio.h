#pragma once
// The empty studio seen by one camera (a clean plate): the mean of many pictures, and how still it was meanwhile.
#include <cstdint>
#include <opencv2/core.hpp>

namespace rotunda::capture {

struct EmptyStudio {
  cv::Mat picture;            // CV_8UC3, RGB: the mean
  std::size_t pictures = 0;   // it is of
  double noise = 0.0;         // median over the pixels of green's standard deviation in time, grey levels
  double moving_share = 0.0;  // of the pixels, 0 .. 1, that changed far more than others as bright: somebody was there
};

class EmptyStudioAverage {
 public:
  // Pictures after the 256th are let go: the sums are 16 bits. Throws InvalidInput for a picture of another size.
  void add(const cv::Mat& rgb);
  std::size_t pictures() const { return pictures_; }
  // Throws InvalidInput without two pictures at least.
  EmptyStudio result() const;

 private:
  cv::Mat sum_;            // CV_16UC3
  cv::Mat green_squares_;  // CV_32FC1
  std::size_t pictures_ = 0;
};

}  // namespace rotunda::capture
