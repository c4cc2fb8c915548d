#pragma once
// A Matte is the performer's soft outline in one camera's image; its 0.5 level is the Silhouette.
#include <opencv2/core.hpp>

namespace rotunda::capture {

struct Matte {
  cv::Mat alpha;  // CV_8UC1, same size as the image: 0 background, 255 performer, 127.5 the sub-pixel outline
};

}  // namespace rotunda::capture
