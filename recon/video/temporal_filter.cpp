#include "recon/video/temporal_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rotunda::recon {

std::array<double, kFilterFrames> filter_weights(int at) {
  Eigen::Matrix<double, kFilterFrames, 4> powers;  // of the frames' times, counted from the middle
  for (int i = 0; i < kFilterFrames; ++i)
    for (int power = 0; power < 4; ++power) powers(i, power) = std::pow(i - kFilterFrames / 2, power);
  const Eigen::Matrix<double, 4, kFilterFrames> fit = (powers.transpose() * powers).inverse() * powers.transpose();
  const Eigen::Matrix<double, 1, kFilterFrames> row = powers.row(at) * fit;
  std::array<double, kFilterFrames> weights{};
  for (int i = 0; i < kFilterFrames; ++i) weights[static_cast<std::size_t>(i)] = row[i];
  return weights;
}

std::vector<Eigen::Vector3f> filtered(std::span<const std::vector<Eigen::Vector3f>, kFilterFrames> window, int at,
                                      float limit) {
  const auto weights = filter_weights(at);
  const auto& raw = window[static_cast<std::size_t>(at)];
  std::vector<Eigen::Vector3f> result(raw.size());
  for (std::size_t v = 0; v < raw.size(); ++v) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < kFilterFrames; ++i) sum += weights[i] * window[i][v].cast<double>();
    const Eigen::Vector3f way = sum.cast<float>() - raw[v];
    const float trust = std::max(0.0F, 1.0F - way.squaredNorm() / (limit * limit));
    result[v] = raw[v] + trust * trust * way;
  }
  return result;
}

}  // namespace rotunda::recon
