#include "capture/source/aravis_frames.h"

#include <utility>

namespace rotunda::capture {

void AravisFrames::expect(const SourceDescription& description, ArvPixelFormat format, bool counts_from_zero) {
  expected_ = {description.width, description.height, description.format, nullptr};
  exposure_ = description.exposure;
  pixel_format_ = format;
  counts_from_zero_ = counts_from_zero;
}

void AravisFrames::begin_count() {
  const std::lock_guard lock(mutex_);
  counter_ = {};
}

void AravisFrames::set_sinks(FrameSink frames, IncompleteSink incomplete) {
  const std::lock_guard lock(mutex_);
  frame_sink_ = std::move(frames);
  incomplete_sink_ = std::move(incomplete);
}

void AravisFrames::follow_clock(const ClockMap& map) {
  const std::lock_guard lock(mutex_);
  guess_clock_ = false;
  clock_map_ = map;
}

void AravisFrames::guess_clock() {
  const std::lock_guard lock(mutex_);
  guess_clock_ = true;
}

bool AravisFrames::is_whole(ArvBuffer* buffer) const {
  return arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS &&
         arv_buffer_get_image_width(buffer) == expected_.width &&
         arv_buffer_get_image_height(buffer) == expected_.height &&
         arv_buffer_get_image_pixel_format(buffer) == pixel_format_;
}

// USB3 Vision counts blocks from 0 with 64 bits; GigE Vision's ids skip 0 and may wrap.
std::optional<std::uint64_t> AravisFrames::exposure_count_of(ArvBuffer* buffer) {
  const std::uint64_t block = arv_buffer_get_frame_id(buffer);
  return counts_from_zero_ ? block : counter_.count(block);
}

// Nothing if the packet that has it was lost.
std::optional<Timestamp> AravisFrames::exposure_start_of(ArvBuffer* buffer) {
  const DeviceTime stamp(static_cast<DeviceTime::rep>(arv_buffer_get_timestamp(buffer)));
  if (stamp.count() == 0) return std::nullopt;
  if (std::exchange(guess_clock_, false))
    clock_map_ = {.rig_origin = Timestamp(guessed_clock_shift(Timestamp(stamp), RigClock::now()))};
  return clock_map_.rig_time(stamp);
}

Frame AravisFrames::frame_in(ArvBuffer* buffer, std::shared_ptr<const std::uint8_t> pixels) {
  const Timestamp start = exposure_start_of(buffer).value_or(Timestamp{});
  Image image{expected_.width, expected_.height, expected_.format, std::move(pixels)};
  return {camera_, 0, exposure_count_of(buffer), start, exposure_, std::move(image)};
}

void AravisFrames::hand_on(ArvBuffer* buffer, BufferPool& pool) {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  const void* data = is_whole(buffer) ? arv_buffer_get_image_data(buffer, &bytes) : nullptr;
  if (data && bytes >= expected_.size_bytes()) {
    Frame frame = frame_in(buffer, pool.lend(buffer, static_cast<const std::uint8_t*>(data)));
    ++whole_;
    if (frame_sink_) frame_sink_(std::move(frame));
    return;
  }
  const auto start = exposure_start_of(buffer);
  pool.give_back(buffer);
  ++incomplete_;
  if (incomplete_sink_) incomplete_sink_({camera_, start});
}

}  // namespace rotunda::capture
