#pragma once
// The layout of a geometry video's file, for its writer and its reader.
#include <array>

#include "recon/video/geometry_video.h"
#include "recon/video/media_file.h"

namespace rotunda::recon {

inline constexpr const char* kHeaderMimeType = "application/json";

inline std::array<VideoStream, 3> geometry_video_streams(const GeometryVideoHeader& header) {
  const int side = (1 << header.level) + 1, colour_side = (1 << header.colour_level) + 1;
  return {lossless_stream("position", "yuv444p16le", side), lossless_stream("colour", "bgr0", colour_side),
          lossless_stream("coverage", "gray", colour_side)};
}

}  // namespace rotunda::recon
