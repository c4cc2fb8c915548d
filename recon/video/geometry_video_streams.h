#pragma once
// The layout of a geometry video's file, for its writer and its reader.
#include <filesystem>
#include <string>
#include <vector>

#include "recon/video/geometry_video.h"
#include "recon/video/media_file.h"

namespace rotunda::recon {

inline constexpr const char* kHeaderMimeType = "application/json";
inline constexpr const char* kMeanMimeType = "application/octet-stream";  // FFmpeg shows pictures as video

// Of this version on a master's colours are UT Video, which decodes four times as fast as FFV1 but has no checksums:
// they stand in the header.
inline constexpr int kColourChecksumVersion = 4;
int version_of(const GeometryVideoHeader& header);  // what a file with this header is written as
std::uint32_t checksum_of(const std::vector<Colour>& colours);

// An AVI has no attachments: they lie beside it, geometry.json and geometry.mean.png by geometry.avi.
inline bool is_avi(const std::filesystem::path& file) {
  return file.extension() == ".avi";
}
inline std::filesystem::path beside(std::filesystem::path file, const std::string& ending) {
  return file.replace_extension() += ending;
}

// The first is (the upper half of) positions, then colours, coverage, and the lower half of the floats.
inline std::vector<VideoStream> geometry_video_streams(const GeometryVideoHeader& header) {
  const int side = (1 << header.level) + 1, colour_side = (1 << header.colour_level) + 1;
  if (header.profile == VideoProfile::stream)
    // Grain that pleases the eye is error in a position; noise in colours is nothing to spend bits on, least in hues.
    return {hevc_stream("position", "yuv444p12le", side, "qp=5:psy-rd=0:psy-rdoq=0"),
            hevc_stream("colour", "yuv444p", colour_side,
                        "crf=21.3:aq-mode=0:psy-rd=0:psy-rdoq=0:cbqpoffs=8:crqpoffs=8:rd=4:subme=3:rdoq-level=2"),
            hevc_stream("coverage", "gray", colour_side, "lossless=1")};
  std::vector<VideoStream> streams{lossless_stream("position", "yuv444p16le", side),
                                   header.version >= kColourChecksumVersion
                                       ? quick_lossless_stream("colour", colour_side)
                                       : lossless_stream("colour", "bgr0", colour_side),
                                   lossless_stream("coverage", "gray", colour_side)};
  if (header.profile == VideoProfile::float32)
    streams.push_back(lossless_stream("position, lower half", "yuv444p16le", side));
  return streams;
}

}  // namespace rotunda::recon
