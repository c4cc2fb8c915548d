#include "capture/take/frame_record.h"

#include "capture/base/crc32c.h"

namespace rotunda::capture {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kPixelsCrc = 4;  // offsets; the version is byte 0, bytes 1 to 3 are zero
constexpr std::size_t kTrigger = 8;
constexpr std::size_t kTriggerTime = 16;
constexpr std::size_t kExposureStart = 24;
constexpr std::size_t kExposure = 32;
constexpr std::size_t kRecordCrc = 40;  // of all bytes before it

template <class Unsigned>
void put(std::span<std::uint8_t> bytes, std::size_t at, Unsigned value) {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

template <class Unsigned>
Unsigned take(std::span<const std::uint8_t> bytes, std::size_t at) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) value |= static_cast<Unsigned>(bytes[at + i]) << (8 * i);
  return value;
}

std::uint64_t nanoseconds(Timestamp time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

std::chrono::nanoseconds take_nanoseconds(std::span<const std::uint8_t> bytes, std::size_t at) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(take<std::uint64_t>(bytes, at)));
}

}  // namespace

std::array<std::uint8_t, kFrameRecordSize> encode(const FrameRecord& record) {
  std::array<std::uint8_t, kFrameRecordSize> bytes{};
  bytes[0] = kVersion;
  put(bytes, kPixelsCrc, record.pixels_crc);
  put(bytes, kTrigger, record.trigger);
  put(bytes, kTriggerTime, nanoseconds(record.trigger_time));
  put(bytes, kExposureStart, nanoseconds(record.exposure_start));
  put(bytes, kExposure, static_cast<std::uint64_t>(record.exposure.count()));
  put(bytes, kRecordCrc, crc32c(std::span(bytes).first(kRecordCrc)));
  return bytes;
}

std::optional<FrameRecord> decode_frame_record(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kFrameRecordSize || bytes[0] != kVersion) return std::nullopt;
  if (take<std::uint32_t>(bytes, kRecordCrc) != crc32c(bytes.first(kRecordCrc))) return std::nullopt;
  FrameRecord record;
  record.trigger = take<std::uint64_t>(bytes, kTrigger);
  record.trigger_time = Timestamp(take_nanoseconds(bytes, kTriggerTime));
  record.exposure_start = Timestamp(take_nanoseconds(bytes, kExposureStart));
  record.exposure = take_nanoseconds(bytes, kExposure);
  record.pixels_crc = take<std::uint32_t>(bytes, kPixelsCrc);
  return record;
}

}  // namespace rotunda::capture
