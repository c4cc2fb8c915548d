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

#include "capture/take/frame_record.h"
#include "capture/take/take.h"

namespace rotunda::capture {

// When the frame's trigger was: by the rig's clock, and since the take's first.
struct TriggerTime {
  Timestamp moment;
  std::chrono::nanoseconds in_take{};
};

// How pixels are kept: as they came, or (always for RGB) as FFV1. Throws InvalidInput for lossless where ffv1_layout()
// is none.
enum class CameraFileCoding { as_it_came, lossless };

class CameraFileWriter {
 public:
  CameraFileWriter(const std::filesystem::path& file, const TakeCamera& camera, double fps,
                   CameraFileCoding coding = CameraFileCoding::as_it_came);
  ~CameraFileWriter();  // leaves the frames written so far readable
  CameraFileWriter(CameraFileWriter&&) noexcept;
  CameraFileWriter& operator=(CameraFileWriter&&) noexcept;

  // Throws InvalidInput if the image's size or format is not the camera's.
  void require_shape(const Image& image) const;
  // The same, and writes.
  void write(const Frame& frame, const TriggerTime& time);
  // A frame that has its record already; what the record says of the pixels is not looked at.
  void write(const Image& image, const FrameRecord& record, std::chrono::nanoseconds in_take);
  // Duration and seek index; then to disk. Nothing can be written afterwards.
  void close();
  // What was written reaches the disk before this returns. Safe beside write() from another thread.
  void sync() const;

 private:
  class Muxer;
  std::unique_ptr<Muxer> muxer_;
};

}  // namespace rotunda::capture
