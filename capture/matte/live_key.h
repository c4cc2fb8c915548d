#pragma once
// The live key: the same rule as chroma_key.h at half the picture's size, straight from the mosaic and in whole
// numbers: about a millisecond a picture of 720 x 576. The outline is that of a two-colour matte at half size, brought
// up to the picture's size; finer than half a pixel on average, not the quarter of chroma_key().
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "capture/frame.h"
#include "capture/matte/backdrop_plate.h"
#include "capture/matte/half_picture.h"
#include "capture/matte/matte.h"

namespace rotunda::capture {

struct LiveKeyOptions {
  std::optional<Backdrop> backdrop;  // nothing: the colour that leads in the plate
  cv::Mat stage;                     // stage_mask.h: where the performer can be; empty: anywhere
};

// What the key finds, as it finds it: at half the picture's size.
struct HalfMatte {
  cv::Mat alpha;        // CV_8UC1, of `box` alone; empty: nobody
  cv::Rect box;         // in half-size pixels; there is nothing of the performer outside of it
  HalfPicture picture;  // that it was found in
};

// One camera's: what its plate asks of every pixel, worked out once. Light that drifts from the plate's is followed.
class LiveKey {
 public:
  // `plate`: CV_8UC3, RGB, the empty studio as this camera shows it; or what fit_plate_picture() makes of a picture
  // with the performer. Throws InvalidInput for a plate without the backdrop's colour, or a stage of another size.
  LiveKey(const cv::Mat& plate, PixelFormat format, const LiveKeyOptions& options = {});

  // Of the plate's size and format; throws InvalidInput otherwise. Safe from any number of threads.
  Matte operator()(const Image& image) const;
  HalfMatte half(const Image& image) const;

 private:
  std::array<std::uint16_t, 3> plate_light(const HalfPicture& half) const;
  cv::Mat inside_of(const HalfPicture& half) const;

  cv::Size size_;
  PixelFormat format_;
  KeyChannels channels_;
  std::array<cv::Mat, 3> scale_;  // CV_16UC1: 2^16 times 256 over the plate
  cv::Mat stage_;                 // CV_8UC1, half size; empty: anywhere
};

// One image a key, side by side on oneTBB's threads.
std::vector<Matte> key_live(std::span<const LiveKey> keys, std::span<const Image> images);

}  // namespace rotunda::capture
