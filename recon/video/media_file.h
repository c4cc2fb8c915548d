#pragma once
// Video files with several streams in step: frame i of every stream shows the same moment. What geometry videos
// (Matroska), paper videos (AVI) and films (MP4) are written with, and read back frame by frame. Pictures come as their
// planes, one cv::Mat each (CV_8UC1 or CV_16UC1; a packed format is one plane, its channels those of the cv::Mat).
// FFmpeg does the work.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace rotunda::recon {

struct VideoStream {
  std::string title;          // what the stream holds, for people
  std::string codec;          // FFmpeg's names: "ffv1", "libx264", "rawvideo"
  std::string pixel_format;   // "yuv444p16le", "bgr0", "gray", "yuv420p", "bgr24"
  int width = 0, height = 0;  // pixels
  std::vector<std::pair<std::string, std::string>> codec_options;
};

struct Attachment {
  std::string name, mime_type, content;
};

struct MediaFileOptions {
  std::string container;  // "matroska", "avi", "mp4"
  double fps = 25.0;
  std::vector<VideoStream> streams;
  std::vector<Attachment> attachments;  // Matroska only
  std::vector<std::pair<std::string, std::string>> container_options;
};

// Lossless, every frame on its own, a checksum for every slice: what masters are kept in.
VideoStream lossless_stream(std::string title, std::string pixel_format, int side);

// Lossless, every frame on its own, planes G, B, R of 8 bits (UT Video): no checksum, but a fourth of FFV1's time to
// decode for a tenth more bytes.
VideoStream quick_lossless_stream(std::string title, int side);

// HEVC without pictures from the future (what goes in comes out at once), a key frame every 25, a checksum for every
// picture; 64 pixels a side or more. quality as x265 has it: "qp=0", "crf=20", "lossless=1".
VideoStream hevc_stream(std::string title, std::string pixel_format, int side, const std::string& quality);

// Writes beside the target and takes its name in finish(); destroyed before that, nothing is left on disk.
// Throws std::system_error with the file's name when the disk does not take it.
class MediaWriter {
 public:
  MediaWriter(const std::filesystem::path& file, const MediaFileOptions& options);
  ~MediaWriter();
  MediaWriter(const MediaWriter&) = delete;
  MediaWriter& operator=(const MediaWriter&) = delete;

  void write(std::size_t stream, std::span<const cv::Mat> planes);  // the stream's next frame
  void finish();

 private:
  struct Output;
  std::unique_ptr<Output> output_;
};

// Any frame, of streams without pictures from the future; cheapest in order. Pictures that stand on others are found
// from the key frame before them. Throws std::system_error if the file
// cannot be opened, CorruptData with file, offset and what is wrong.
class MediaReader {
 public:
  explicit MediaReader(const std::filesystem::path& file);
  ~MediaReader();
  MediaReader(const MediaReader&) = delete;
  MediaReader& operator=(const MediaReader&) = delete;

  std::string attachment(const std::string& mime_type) const;  // empty if there is none

  // What the file must hold, in order; nothing is decoded before this.
  void expect(std::span<const VideoStream> streams, double fps);

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  // The planes of every stream at frame `index`; of stream `without` none, and nothing of it is decoded.
  std::vector<std::vector<cv::Mat>> read(std::int64_t index, std::size_t without = kNone);

 private:
  struct Input;
  std::unique_ptr<Input> input_;
};

}  // namespace rotunda::recon
