#pragma once
// Private to recon/video: the positions of one frame as the pictures of their streams, and back, as the profile has it.
//   master   x, y, z relative to the root: 16 bits over the header's box
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
  // mean_png: profile stream's; else not looked at. Throws CorruptData if it is not of the header's level.
  PositionCoding(const GeometryVideoHeader& header, const std::string& mean_png);

  // The planes of each stream of positions. Throws InvalidInput if a position lies outside the header's box.
  std::vector<std::vector<cv::Mat>> encode(const std::vector<Eigen::Vector3f>& positions,
                                           const Eigen::Vector3d& root) const;
  // pictures: of all the video's streams. Every stride-th sample of every stride-th row.
  std::vector<Eigen::Vector3f> decode(std::span<const std::vector<cv::Mat>> pictures, const Eigen::Vector3d& root,
                                      int stride) const;

 private:
  VideoProfile profile_;
  int side_;
  Eigen::AlignedBox3d box_;
  double steps_;                       // of the box
  std::vector<Eigen::Vector3d> mean_;  // stream: of each sample
};

// The sequence's mean as it goes into the file: a PNG, 16 bits over the header's box. Throws InvalidInput if it is not
// of the header's level.
std::string encode_mean(const GeometryVideoHeader& header, const std::vector<Eigen::Vector3f>& mean);

}  // namespace rotunda::recon
