#include "recon/video/mean_surface.h"

#include <fmt/format.h>

#include "config/errors.h"

namespace rotunda::recon {

void MeanSurface::add(const std::vector<Eigen::Vector3f>& positions, const Eigen::Vector3d& root) {
  if (frames_ == 0) samples_.resize(positions.size());
  if (positions.size() != samples_.size())
    throw InvalidInput(
        fmt::format("a surface of {} samples has no mean with one of {}", positions.size(), samples_.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d in_place = positions[i].cast<double>() - root;
    samples_[i].sum += in_place;
    samples_[i].range.extend(in_place.cast<float>());
  }
  ++frames_;
}

std::vector<Eigen::Vector3f> MeanSurface::positions() const {
  std::vector<Eigen::Vector3f> mean;
  mean.reserve(samples_.size());
  for (const auto& sample : samples_) mean.push_back((sample.sum / frames_).cast<float>());
  return mean;
}

Eigen::AlignedBox3d MeanSurface::differences() const {
  Eigen::AlignedBox3d box;
  for (const auto& sample : samples_) {
    const Eigen::Vector3d mean = sample.sum / frames_;
    box.extend(sample.range.min().cast<double>() - mean);
    box.extend(sample.range.max().cast<double>() - mean);
  }
  return box;
}

}  // namespace rotunda::recon
