#pragma once
// Frames and their time. A Frame is one image of one camera, a FrameSet the frames of one trigger.
// Pixels lie as the camera sent them: rows top to bottom, no padding between rows; 8 bits a sample, or 12 packed as
// PFNC says: two pixels in three bytes, lower bits first, rows following each other without a gap.
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rotunda::capture {

// The rig's one clock: International Atomic Time, nanoseconds since 1970-01-01 TAI.
struct RigClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<RigClock>;
  static constexpr bool is_steady = false;
  static time_point now() noexcept;  // CLOCK_TAI
};
using Timestamp = std::chrono::time_point<RigClock, std::chrono::nanoseconds>;

// A camera's name in the rig file, "cam00"; also its file name in a take.
using CameraId = std::string;

enum class PixelFormat { mono8, bayer_rg8, bayer_gr8, bayer_gb8, bayer_bg8, rgb8, bayer_rg12p };

std::size_t bytes_per_pixel(PixelFormat format);  // whole bytes that hold one: 2 for 12 bits
std::size_t image_bytes(int width, int height, PixelFormat format);
std::string_view to_string(PixelFormat format);                               // "BayerRG8": the GenICam name
std::optional<PixelFormat> pixel_format_from(std::string_view genicam_name);  // nothing if we do not know it

// Shared, immutable pixels: whoever owns the memory (a vector, an Aravis buffer) stays alive as long as a copy.
struct Image {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
  std::shared_ptr<const std::uint8_t> pixels;

  std::size_t size_bytes() const { return image_bytes(width, height, format); }
  std::span<const std::uint8_t> bytes() const { return {pixels.get(), pixels ? size_bytes() : 0}; }
};

// Takes ownership of `bytes`; throws InvalidInput if there are fewer than the size asks for.
Image make_image(int width, int height, PixelFormat format, std::vector<std::uint8_t> bytes);

struct Frame {
  CameraId camera;
  std::uint64_t trigger = 0;            // counted from the start of the take; gaps are dropped frames
  std::optional<std::uint64_t> id;      // the camera's own count of its exposures, never wrapping; nothing: it has none
  Timestamp exposure_start;             // shutter opens
  std::chrono::nanoseconds exposure{};  // mid-exposure = exposure_start + exposure / 2
  Image image;
};

// Why a frame set has no frame of a camera.
enum class HoleReason {
  late,            // not here by the set's deadline, nobody knows why
  packets_lost,    // exposed, lost on the wire
  camera_lost,     // the camera was not there
  trigger_missed,  // the camera was there and did not expose
  disk_too_slow,   // came, and could not be written in time
  not_recorded,    // nothing in the take says why
  corrupt,         // in the take, but not as it was recorded
};
std::string_view to_string(HoleReason reason);  // "packets lost"
std::optional<HoleReason> hole_reason_from(std::string_view words);
std::span<const HoleReason> hole_reasons();  // all, as above

// One trigger: a slot per camera of the rig, in the rig's order; a hole says why.
struct FrameSlot {
  std::optional<Frame> frame;
  std::optional<HoleReason> missing_because;  // nothing when there is a frame
};

struct FrameSet {
  std::uint64_t trigger = 0;
  Timestamp time;  // the moment the trigger was scheduled for
  std::vector<FrameSlot> slots;

  bool complete() const;
};

}  // namespace rotunda::capture
