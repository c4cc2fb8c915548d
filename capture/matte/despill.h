#pragma once
// The performer's own colours: at the outline a pixel mixes performer and backdrop, and the backdrop's light lies on
// the rim. Both are taken out, the first by the matte (Smith and Blinn 1996), the second only as far as the rim leads
// the cloth just inside of it in the backdrop's colour, so that blue clothes stay blue.
#include <opencv2/core.hpp>

#include "capture/frame.h"
#include "capture/matte/backdrop_plate.h"
#include "capture/matte/matte.h"

namespace rotunda::capture {

// `rgb` CV_8UC3, `matte` of its size. Returns CV_8UC3: as it was deep inside; the performer's colours at and a few
// pixels beyond the outline, so that it can be sampled between pixels; as it was farther out.
// Throws InvalidInput for other sizes or types.
cv::Mat despilled(const cv::Mat& rgb, const Matte& matte, Backdrop backdrop);

// The same of an image as its camera sent it, to CV_8UC3. Of a mosaic the backdrop is taken out of the photosites
// before demosaicing carries it into its neighbours; anything else goes as above. Throws CorruptData as to_rgb() does.
cv::Mat despilled(const Image& image, const Matte& matte, Backdrop backdrop);

}  // namespace rotunda::capture
