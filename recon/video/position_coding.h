#pragma once
// Private to recon/video: the positions of one frame as the pictures of their streams, and back, as the profile has it.
//   master   x, y, z relative to the root (from_mean: and to the sequence's mean): 16 bits over the header's box
//   float32  the IEEE bits of x, y, z relative to the root: the upper 16 in the first stream, the lower in the last
//   stream   x, y, z relative to the root and the sequence's mean: 12 bits over the header's difference box
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "recon/video/geometry_video.h"

namespace rotunda::recon {

class PositionCoding {
 public:
  // mean_png: not looked at unless the header says from_mean. Throws CorruptData if it is not of the header's level.
  PositionCoding(const GeometryVideoHeader& header, const std::string& mean_png);

  // The planes of each stream of positions. Throws InvalidInput if a position lies outside the header's box.
  std::vector<std::vector<cv::Mat>> encode(const std::vector<Eigen::Vector3f>& positions,
                                           const Eigen::Vector3d& root) const;
  // pictures: of all the video's streams. Every stride-th sample of every stride-th row.
  std::vector<Eigen::Vector3f> decode(std::span<const std::vector<cv::Mat>> pictures, const Eigen::Vector3d& root,
                                      int stride) const;

 private:
  // One row, every stride-th sample.
  void decode_floats(std::span<const std::vector<cv::Mat>> pictures, const Eigen::Vector3d& root, int row, int stride,
                     Eigen::Vector3f* to) const;
  void decode_steps(const std::vector<cv::Mat>& planes, const Eigen::Vector3d& root, int row, int stride,
                    Eigen::Vector3f* to) const;

  VideoProfile profile_;
  int side_;
  Eigen::AlignedBox3d box_;
  double steps_;                       // of the box
  std::vector<Eigen::Vector3d> mean_;  // of each sample; empty without one
};

// What the differences are coded over: equal steps along all axes, for a stream as fine as its 12 bits reach, for a
// master 0.039 mm, which is 0.02 mm RMS in space; coarser where 16 bits do not reach. Finer ones would only code noise.
Eigen::AlignedBox3d difference_box(const GeometryVideoHeader& header, const MeanSurface& mean);

// The sequence's mean as it goes into the file: a PNG, 16 bits over the header's box. Throws InvalidInput if it is not
// of the header's level.
std::string encode_mean(const GeometryVideoHeader& header, const std::vector<Eigen::Vector3f>& mean);

}  // namespace rotunda::recon
