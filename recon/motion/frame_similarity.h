#pragma once
// How alike the frames of clips are: the distance of their surfaces once one is laid over the other on the floor
// (turned about the vertical and shifted, Kovar, Gleicher, Pighin 2002, eq. (1)-(4)), root mean square over the
// surface's area, metres. Samples must correspond; clips travel over a floor that stands (gait_events.h: travel).
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "recon/motion/clip_shape.h"
#include "recon/motion/floor_pose.h"

namespace rotunda::recon {

// Sums over the samples of two frames, or of windows of frames: what the best pose and the distance follow from.
struct PairSums {
  double weight = 0.0, px = 0.0, py = 0.0, qx = 0.0, qy = 0.0;
  double dot = 0.0, cross = 0.0;        // of the horizontal parts: p . q, q x p
  double squares = 0.0, heights = 0.0;  // |p|^2 + |q|^2 horizontally; (pz - qz)^2

  PairSums& operator+=(const PairSums& other);
};

struct FramePair {
  FloorPose pose;         // a_from_b: lays b's frames over a's
  double distance = 0.0;  // metres
};
FramePair lay_over(const PairSums& sums);

// Sums of every frame of `a` with every frame of `b`, at a coarse level (5).
class PairTable {
 public:
  PairTable(const ClipShape& a, const ClipShape& b);
  int rows() const { return rows_; }        // frames of a
  int columns() const { return columns_; }  // of b
  // `count` frames from (i, j) on, as one rigid window; it must lie within both clips.
  FramePair window(int i, int j, int count) const;

 private:
  int rows_, columns_;
  std::vector<PairSums> sums_;
};

// One pair at the clips' own level; `weights` one a sample.
FramePair lay_over(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b,
                   const std::vector<float>& weights);

// The matrix as a picture, CV_8UC3, RGB, a row a frame of `a`, `cell` pixels a frame: dark is alike, `farthest` metres
// and more are bright.
cv::Mat similarity_picture(const PairTable& table, int cell, double farthest);

}  // namespace rotunda::recon
