#pragma once
// Writes one camera's Matroska file of a take: pixels as they came (mono and Bayer V_UNCOMPRESSED as Y800, Y'CbCr
// V_UNCOMPRESSED under its own name, Motion JPEG V_MJPEG), RGB as lossless FFV1. One frame a cluster, handed to the
// kernel before write() returns, so a killed process loses at most the frame it was writing. The raw way copies pixels
// only inside libavformat's cluster buffer and into the kernel.
//
// Throws std::system_error naming the file. After a failed write the file is cut back to its last whole frame and
// stays readable; further writes throw the same error.
#include <filesystem>
#include <memory>

#include "capture/take/take.h"

namespace rotunda::capture {

// When the frame's trigger was: by the rig's clock, and since the take's first.
struct TriggerTime {
  Timestamp moment;
  std::chrono::nanoseconds in_take{};
};

class CameraFileWriter {
 public:
  CameraFileWriter(const std::filesystem::path& file, const TakeCamera& camera, double fps);
  ~CameraFileWriter();  // leaves the frames written so far readable
  CameraFileWriter(CameraFileWriter&&) noexcept;
  CameraFileWriter& operator=(CameraFileWriter&&) noexcept;

  // Throws InvalidInput if the image's size or format is not the camera's.
  void require_shape(const Image& image) const;
  // The same, and writes.
  void write(const Frame& frame, const TriggerTime& time);
  // Duration and seek index; then to disk. Nothing can be written afterwards.
  void close();
  // What was written reaches the disk before this returns. Safe beside write() from another thread.
  void sync() const;

 private:
  class Muxer;
  std::unique_ptr<Muxer> muxer_;
};

}  // namespace rotunda::capture
