#include "recon/video/position_coding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr double kSteps16 = 65535.0, kSteps12 = 4095.0;

using Planes = std::vector<cv::Mat>;

Planes empty_planes(int side) {
  Planes planes;
  for (int axis = 0; axis < 3; ++axis) planes.emplace_back(side, side, CV_16UC1);
  return planes;
}

std::uint16_t step_of(double value, double low, double extent, double steps) {
  const double step = extent > 0.0 ? std::round((value - low) / extent * steps) : 0.0;
  if (!(step >= -1.0 && step <= steps + 1.0))  // one step of slack for rounding; not so for NaN
    throw InvalidInput("a position lies outside the geometry video's box; was the frame added to the header?");
  return static_cast<std::uint16_t>(std::clamp(step, 0.0, steps));
}

std::vector<Eigen::Vector3d> decode_mean(const GeometryVideoHeader& header, const std::string& png) {
  const int side = (1 << header.level) + 1;
  cv::Mat picture;
  if (!png.empty())
    picture = cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);  // blue first
  if (picture.type() != CV_16UC3 || picture.rows != side || picture.cols != side)
    throw CorruptData("the mean of the positions is missing or of another size");
  std::vector<Eigen::Vector3d> mean;
  const Eigen::Vector3d extent = header.box.sizes();
  for (const auto& pixel : cv::Mat_<cv::Vec3w>(picture))
    mean.push_back(header.box.min() + extent.cwiseProduct(Eigen::Vector3d(pixel[2], pixel[1], pixel[0])) / kSteps16);
  return mean;
}

}  // namespace

PositionCoding::PositionCoding(const GeometryVideoHeader& header, const std::string& mean_png)
    : profile_(header.profile),
      side_((1 << header.level) + 1),
      box_(header.from_mean ? header.difference_box : header.box),
      steps_(header.profile == VideoProfile::stream ? kSteps12 : kSteps16) {
  if (header.from_mean) mean_ = decode_mean(header, mean_png);
}

std::vector<Planes> PositionCoding::encode(const std::vector<Eigen::Vector3f>& positions,
                                           const Eigen::Vector3d& root) const {
  std::vector<Planes> streams{empty_planes(side_)};
  if (profile_ == VideoProfile::float32) streams.push_back(empty_planes(side_));
  const Eigen::Vector3d low = box_.min(), extent = box_.sizes();
  for (int axis = 0; axis < 3; ++axis) {
    auto* upper = streams[0][static_cast<std::size_t>(axis)].ptr<std::uint16_t>();
    auto* lower = streams.back()[static_cast<std::size_t>(axis)].ptr<std::uint16_t>();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      double value = static_cast<double>(positions[i][axis]) - root[axis];
      if (profile_ == VideoProfile::float32) {
        const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
        upper[i] = static_cast<std::uint16_t>(bits >> 16);
        lower[i] = static_cast<std::uint16_t>(bits & 0xffff);
        continue;
      }
      if (!mean_.empty()) value -= mean_[i][axis];
      upper[i] = step_of(value, low[axis], extent[axis], steps_);
    }
  }
  return streams;
}

std::vector<Eigen::Vector3f> PositionCoding::decode(std::span<const Planes> pictures, const Eigen::Vector3d& root,
                                                    int stride) const {
  const auto samples = static_cast<std::size_t>((side_ - 1) / stride + 1);
  std::vector<Eigen::Vector3f> positions(samples * samples);
  auto* next = positions.data();
  for (int row = 0; row < side_; row += stride, next += samples) {
    if (profile_ == VideoProfile::float32)
      decode_floats(pictures, root, row, stride, next);
    else
      decode_steps(pictures.front(), root, row, stride, next);
  }
  return positions;
}

void PositionCoding::decode_floats(std::span<const Planes> pictures, const Eigen::Vector3d& root, int row, int stride,
                                   Eigen::Vector3f* to) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto* upper = pictures.front()[axis].ptr<std::uint16_t>(row);
    const auto* lower = pictures.back()[axis].ptr<std::uint16_t>(row);
    const auto a = static_cast<Eigen::Index>(axis);
    for (int column = 0, i = 0; column < side_; column += stride, ++i) {
      const auto value = std::bit_cast<float>((std::uint32_t{upper[column]} << 16) | lower[column]);
      if (!std::isfinite(value)) throw CorruptData("a position is not a finite number");
      to[i][a] = static_cast<float>(static_cast<double>(value) + root[a]);
    }
  }
}

// Axis by axis, so that the compiler makes it wide.
void PositionCoding::decode_steps(const Planes& planes, const Eigen::Vector3d& root, int row, int stride,
                                  Eigen::Vector3f* to) const {
  const Eigen::Vector3d low = box_.min() + root, metres_per_step = box_.sizes() / steps_;
  const auto first = static_cast<std::size_t>(row) * static_cast<std::size_t>(side_);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto* steps = planes[static_cast<std::size_t>(axis)].ptr<std::uint16_t>(row);
    const double origin = low[axis], scale = metres_per_step[axis];
    for (int column = 0, i = 0; column < side_; column += stride, ++i) {
      const double mean = mean_.empty() ? 0.0 : mean_[first + static_cast<std::size_t>(column)][axis];
      to[i][axis] = static_cast<float>(origin + scale * steps[column] + mean);
    }
  }
}

Eigen::AlignedBox3d difference_box(const GeometryVideoHeader& header, const MeanSurface& mean) {
  constexpr double kMasterStep = 39e-6;  // metres
  const auto box = mean.differences();
  // What 16 bits take from the mean, the differences must hold.
  double edge = (box.sizes() + 2.0 * header.box.sizes() / kSteps16).maxCoeff();
  if (header.profile == VideoProfile::master) edge = std::max(edge, kMasterStep * kSteps16);
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * edge);
  return {box.center() - half, box.center() + half};
}

std::string encode_mean(const GeometryVideoHeader& header, const std::vector<Eigen::Vector3f>& mean) {
  const int side = (1 << header.level) + 1;
  if (mean.size() != static_cast<std::size_t>(side) * static_cast<std::size_t>(side))
    throw InvalidInput("a geometry video to be streamed needs the mean of its positions");
  cv::Mat picture(side, side, CV_16UC3);
  const Eigen::Vector3d low = header.box.min(), extent = header.box.sizes();
  for (std::size_t i = 0; i < mean.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      picture.ptr<cv::Vec3w>()[i][2 - axis] =
          step_of(static_cast<double>(mean[i][axis]), low[axis], extent[axis], kSteps16);
  std::vector<std::uint8_t> png;
  if (!cv::imencode(".png", picture, png)) throw InvalidInput("the mean of the positions cannot be made a picture");
  return {png.begin(), png.end()};
}

}  // namespace rotunda::recon
