#pragma once
// A stream's buffers as frames: whole ones with their exposure's start on the rig's clock and the camera's own count of
// exposures, all others as losses. Pixels are lent, not copied (buffer_pool.h). hand_on() belongs to the stream's
// thread, the rest to the camera's.
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>

#include "capture/source/aravis_handle.h"
#include "capture/source/buffer_pool.h"
#include "capture/source/exposure_counter.h"
#include "capture/source/source.h"
#include "capture/sync/clock_model.h"

namespace rotunda::capture {

class AravisFrames {
 public:
  explicit AravisFrames(CameraId camera) : camera_(std::move(camera)) {}

  // What a whole frame looks like. While nothing streams.
  void expect(const SourceDescription& description, ArvPixelFormat format, bool counts_from_zero);
  // The camera begins its count anew.
  void begin_count();
  // No sink is called any more once they have been taken away.
  void set_sinks(FrameSink frames, IncompleteSink incomplete);
  // How the camera's time stamps come to the rig's clock; where nothing is known, the next frame's arrival will tell.
  void follow_clock(const ClockMap& map);
  void guess_clock();

  // A buffer that has been popped from the stream.
  void hand_on(ArvBuffer* buffer, BufferPool& pool);

  std::uint64_t whole() const { return whole_; }
  std::uint64_t incomplete() const { return incomplete_; }
  std::uint64_t heard() const { return whole_ + incomplete_; }

 private:
  bool is_whole(ArvBuffer* buffer) const;
  std::optional<std::uint64_t> exposure_count_of(ArvBuffer* buffer);
  std::optional<Timestamp> exposure_start_of(ArvBuffer* buffer);
  Frame frame_in(ArvBuffer* buffer, std::shared_ptr<const std::uint8_t> pixels);

  const CameraId camera_;
  std::atomic<std::uint64_t> whole_{0}, incomplete_{0};

  Image expected_;  // without pixels
  ArvPixelFormat pixel_format_ = 0;
  std::chrono::nanoseconds exposure_{};
  bool counts_from_zero_ = false;

  std::mutex mutex_;  // guards what follows; held while a sink is called
  ExposureCounter counter_;
  FrameSink frame_sink_;
  IncompleteSink incomplete_sink_;
  ClockMap clock_map_;
  bool guess_clock_ = false;
};

}  // namespace rotunda::capture
