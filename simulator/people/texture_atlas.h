#pragma once
// Several pictures laid side by side in one, for a SurfaceTexture. Each has a margin of its own colour around it, so
// that linear filtering never reads a stranger's.
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace rotunda::simulator {

struct TextureAtlas {
  cv::Mat picture;                     // CV_8UC3
  std::vector<Eigen::Vector2f> place;  // top left corner of each picture, in texels
  float scale = 1.0F;                  // of all pictures: texels of the atlas a texel of theirs; 1 if they fit
  // Where a place in one of the pictures, in its texels, is in the atlas.
  Eigen::Vector2f at(std::size_t picture, const Eigen::Vector2f& texel) const;
};

// `largest`: of either side of the atlas, texels; the pictures shrink to fit. CV_8UC3 each, none empty.
TextureAtlas pack_pictures(const std::vector<cv::Mat>& pictures, int largest = 8192);

}  // namespace rotunda::simulator
