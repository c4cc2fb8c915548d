#pragma once
// The pieces that hang together in a mask, and what becomes of each.
#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace rotunda::capture {

// Turns the pieces of `value` (0 or 255) over that `goes` says of, by their statistics (cv::ConnectedComponentsTypes)
// and how many of their pixels are `marked`.
template <class Goes>
void turn_pieces(cv::Mat mask, std::uint8_t value, const cv::Mat& marked, const Goes& goes) {
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(mask == value, labels, statistics, centres, value ? 8 : 4, CV_32S);
  std::vector<int> marks(static_cast<std::size_t>(count), 0);
  if (cv::countNonZero(marked) > 0)
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x)
        if (marked.at<std::uint8_t>(y, x)) ++marks[static_cast<std::size_t>(labels.at<int>(y, x))];
  std::vector<std::uint8_t> after(static_cast<std::size_t>(count), value);
  after[0] = static_cast<std::uint8_t>(255 - value);
  for (int piece = 1; piece < count; ++piece)
    if (goes(statistics.ptr<int>(piece), marks[static_cast<std::size_t>(piece)]))
      after[static_cast<std::size_t>(piece)] = after[0];
  for (int y = 0; y < mask.rows; ++y)
    std::transform(labels.ptr<int>(y), labels.ptr<int>(y) + mask.cols, mask.ptr<std::uint8_t>(y),
                   [&](int label) { return after[static_cast<std::size_t>(label)]; });
}

}  // namespace rotunda::capture
