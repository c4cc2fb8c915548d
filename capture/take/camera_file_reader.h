#pragma once
// Reads one camera's Matroska file of a take, whole or cut short. Opening it walks over the blocks' headers and
// records once, without reading the pixels; any frame is then one read away.
// Opening never throws for what is wrong with the file: frames() holds what can be found, problem() says what is wrong.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/readable_file.h"
#include "capture/take/frame_record.h"
#include "capture/take/take.h"

struct AVStream;

namespace rotunda::capture {

// A block of the file. Without a record (damaged, or written by another program) its trigger is not known.
struct StoredFrame {
  std::optional<FrameRecord> record;
  std::int64_t offset = 0;  // of its bytes in the file
  std::size_t size = 0;     // bytes
};

// What the file's own header says, for a take whose take.yaml is lost. The name is the file's. Throws CorruptData if
// it is no camera's file of a take, std::system_error if it cannot be read.
struct CameraFileHeader {
  TakeCamera camera;  // no counts
  double fps = 0.0;
};
CameraFileHeader read_camera_file_header(const std::filesystem::path& file);

class CameraFileReader {
 public:
  CameraFileReader(const std::filesystem::path& file, const TakeCamera& camera);

  const std::vector<StoredFrame>& frames() const { return frames_; }  // in the file's order
  const std::string& problem() const { return problem_; }             // empty if the file ends as it should

  // The frame's pixels, checked against its CRC; nothing if they are not what was recorded. Several threads may read.
  // Throws std::system_error if the disk fails.
  std::optional<Frame> read(const StoredFrame& stored) const;
  // The pixels alone, whatever their CRC says; nothing if they cannot be had.
  std::optional<std::vector<std::uint8_t>> read_bytes(const StoredFrame& stored) const;
  bool lossless() const { return lossless_; }  // FFV1, not as it came

 private:
  void index();
  void require_coding(const AVStream& stream);

  std::filesystem::path file_;
  TakeCamera camera_;
  std::optional<ReadableFile> input_;
  bool lossless_ = false;
  std::vector<std::uint8_t> ffv1_configuration_;  // CodecPrivate
  std::vector<StoredFrame> frames_;
  std::string problem_;
};

}  // namespace rotunda::capture
