#pragma once
// The sRGB curve (IEC 61966-2-1) between 8-bit pixels and linear light, 0 to 1.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace rotunda::capture {

double linear_of_srgb(double srgb);  // both 0 to 1
double srgb_of_linear(double linear);
const std::array<float, 256>& linear_table();  // by 8-bit value
inline Eigen::Vector3d linear_of(const cv::Vec3b& pixel) {
  const auto& table = linear_table();
  return {table[pixel[0]], table[pixel[1]], table[pixel[2]]};
}
std::uint8_t srgb8_of(double linear);

// CV_8UC3 -> CV_8UC3 with `matrix` applied in linear light; what leaves 0 to 1 is cut off.
cv::Mat with_matrix(const cv::Mat& rgb, const Eigen::Matrix3d& matrix);

}  // namespace rotunda::capture
