#pragma once
// The mean of a sequence of surfaces, sample by sample, each relative to its frame's root, and how far the surfaces
// leave it: what is coded instead of positions, since most of a surface keeps to its place (Briceno et al. 2003 code
// differences likewise). Metres.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace rotunda::recon {

class MeanSurface {
 public:
  // The next frame's positions, world. Throws InvalidInput if it has another number of samples than the others.
  void add(const std::vector<Eigen::Vector3f>& positions, const Eigen::Vector3d& root);

  bool empty() const { return frames_ == 0; }
  std::vector<Eigen::Vector3f> positions() const;  // relative to the root
  Eigen::AlignedBox3d differences() const;         // of all positions added minus their mean

 private:
  struct Sample {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::AlignedBox3f range;
  };
  std::vector<Sample> samples_;
  int frames_ = 0;
};

}  // namespace rotunda::recon
