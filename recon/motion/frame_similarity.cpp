#include "recon/motion/frame_similarity.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {
namespace {

constexpr int kCoarseLevel = 5;  // 33 x 33 samples, one every 4 cm of a person

void add_sample(PairSums& sums, double weight, const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  sums.weight += weight;
  sums.px += weight * p.x();
  sums.py += weight * p.y();
  sums.qx += weight * q.x();
  sums.qy += weight * q.y();
  sums.dot += weight * (p.x() * q.x() + p.y() * q.y());
  sums.cross += weight * (q.x() * p.y() - q.y() * p.x());
  sums.squares += weight * (p.head<2>().squaredNorm() + q.head<2>().squaredNorm());
  sums.heights += weight * (p.z() - q.z()) * (p.z() - q.z());
}

// Raster indices of a coarse lattice's samples, without the border's copies.
std::vector<std::size_t> coarse_samples(int level) {
  std::vector<std::size_t> samples;
  const int side = lattice_side(level), stride = 1 << std::max(0, level - kCoarseLevel);
  for (int y = 0; y < side; y += stride)
    for (int x = 0; x < side; x += stride)
      if (canonical_sample(level, x, y) == static_cast<std::uint32_t>(y * side + x))
        samples.push_back(static_cast<std::size_t>(y * side + x));
  return samples;
}

}  // namespace

PairSums& PairSums::operator+=(const PairSums& other) {
  weight += other.weight;
  px += other.px;
  py += other.py;
  qx += other.qx;
  qy += other.qy;
  dot += other.dot;
  cross += other.cross;
  squares += other.squares;
  heights += other.heights;
  return *this;
}

FramePair lay_over(const PairSums& sums) {
  const double w = std::max(sums.weight, 1e-12);
  const Eigen::Vector2d p(sums.px / w, sums.py / w), q(sums.qx / w, sums.qy / w);
  const double c = sums.dot - w * p.dot(q), s = sums.cross - w * (q.x() * p.y() - q.y() * p.x());
  FramePair pair;
  pair.pose.yaw = std::atan2(s, c);
  const Eigen::Vector2d turned = FloorPose{0.0, 0.0, pair.pose.yaw} * q;
  pair.pose.x = p.x() - turned.x();
  pair.pose.y = p.y() - turned.y();
  const double spread = sums.squares - w * (p.squaredNorm() + q.squaredNorm());
  pair.distance = std::sqrt(std::max(0.0, spread - 2.0 * std::hypot(c, s) + sums.heights) / w);
  return pair;
}

PairTable::PairTable(const ClipShape& a, const ClipShape& b)
    : rows_(a.frame_count()), columns_(b.frame_count()), sums_(a.frames.size() * b.frames.size()) {
  if (a.level != b.level) throw InvalidInput(a.name + " and " + b.name + " are of different levels");
  const auto samples = coarse_samples(a.level);
  tbb::parallel_for(0, rows_, [&](int i) {
    for (int j = 0; j < columns_; ++j) {
      PairSums& sums = sums_[static_cast<std::size_t>(i * columns_ + j)];
      for (const std::size_t k : samples)
        add_sample(sums, static_cast<double>(a.areas[k] + b.areas[k]),
                   a.frames[static_cast<std::size_t>(i)][k].cast<double>(),
                   b.frames[static_cast<std::size_t>(j)][k].cast<double>());
    }
  });
}

FramePair PairTable::window(int i, int j, int count) const {
  PairSums sums;
  for (int k = 0; k < count; ++k) sums += sums_[static_cast<std::size_t>((i + k) * columns_ + j + k)];
  return lay_over(sums);
}

FramePair lay_over(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b,
                   const std::vector<float>& weights) {
  PairSums sums;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (weights[i] > 0.0F) add_sample(sums, static_cast<double>(weights[i]), a[i].cast<double>(), b[i].cast<double>());
  return lay_over(sums);
}

cv::Mat similarity_picture(const PairTable& table, int cell, double farthest) {
  cv::Mat picture(table.rows() * cell, table.columns() * cell, CV_8UC3);
  for (int i = 0; i < table.rows(); ++i)
    for (int j = 0; j < table.columns(); ++j) {
      const double share = std::sqrt(std::min(1.0, table.window(i, j, 1).distance / farthest));
      const cv::Scalar colour(20 + 235 * share, 24 + 200 * share * share, 60 + 120 * share * share);
      cv::rectangle(picture, cv::Rect(j * cell, i * cell, cell, cell), colour, cv::FILLED);
    }
  return picture;
}

}  // namespace rotunda::recon
