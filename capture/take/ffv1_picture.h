#pragma once
// Cameras' images as lossless pictures: FFV1 (RFC 9043) version 3, every one a key frame, in four slices with a CRC
// each. A mosaic goes in as its four quadrants, each the samples of one place of the 2 x 2 pattern: neighbours of one
// colour predict each other, neighbours of two do not. docs/take-format.md has the layouts.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "capture/base/av_objects.h"
#include "capture/take/take.h"

struct AVCodecParameters;
struct AVRational;

namespace rotunda::capture {

// How an image lies in its FFV1 picture.
enum class Ffv1Layout {
  none,       // not at all: a JPEG, or bytes that samples do not fill
  rgb,        // red, green, blue
  grey,       // one sample a pixel, where it was
  quadrants,  // even rows above, odd below; even columns left, odd right; 16-bit samples if they have more than eight
  planes,     // Y', Cb, Cr
};
Ffv1Layout ffv1_layout(const TakeCamera& camera);
std::string_view to_string(Ffv1Layout layout);                // "bayer-quadrants"
inline constexpr const char* kFfv1LayoutTag = "FFV1_LAYOUT";  // of the track, says which

class Ffv1Encoder {
 public:
  // Throws InvalidInput where the layout is none, std::system_error if this FFmpeg has no FFV1.
  Ffv1Encoder(const TakeCamera& camera, const AVRational& rate);

  void describe(AVCodecParameters& parameters) const;
  AvPacket encode(const Image& image);  // of the camera's size and format

 private:
  TakeCamera camera_;
  AvCodec codec_;
  std::int64_t encoded_ = 0;  // pictures
};

// The image's bytes as the camera sent them; nothing if FFV1's own checks find damage, or it is another kind of
// picture. `configuration` is Matroska's CodecPrivate.
std::optional<std::vector<std::uint8_t>> decode_ffv1(std::span<const std::uint8_t> configuration,
                                                     std::span<const std::uint8_t> bytes, const TakeCamera& camera);

}  // namespace rotunda::capture
