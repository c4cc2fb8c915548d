#pragma once
// Frames and their time. A Frame is one image of one camera, a FrameSet the frames of one trigger.
// Pixels lie as the camera sent them: rows top to bottom, no padding between rows, packed as the format's name says.
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
  // CLOCK_TAI, but without its steps when somebody sets this machine's clock (base/host_clock.h).
  static time_point now() noexcept;
};
using Timestamp = std::chrono::time_point<RigClock, std::chrono::nanoseconds>;

// A camera's name in the rig file, "cam00"; also its file name in a take.
using CameraId = std::string;

enum class PixelFormat {
  mono8,
  bayer_rg8,
  bayer_gr8,
  bayer_gb8,
  bayer_bg8,
  rgb8,
  bayer_rg12p,
  bayer_rg10,
  bayer_gr10,
  bayer_gb10,
  bayer_bg10,
  bayer_rg12,
  bayer_gr12,
  bayer_gb12,
  bayer_bg12,
  bayer_rg10_csi2p,
  bayer_gr10_csi2p,
  bayer_gb10_csi2p,
  bayer_bg10_csi2p,
  bayer_rg12_csi2p,
  bayer_gr12_csi2p,
  bayer_gb12_csi2p,
  bayer_bg12_csi2p,
  yuyv,
  uyvy,
  nv12,
  mjpeg
};

// How samples lie in memory.
enum class PixelPacking {
  bytes,     // a byte a sample
  words,     // two bytes a sample, lower first; the value in the low bits
  pfnc_12p,  // two samples in three bytes, lower bits first (GenICam PFNC "12p"), rows following without a gap
  csi2_10p,  // four samples in five bytes: their high eight bits each, then the low two of all (MIPI CSI-2 RAW10)
  csi2_12p,  // two samples in three bytes, likewise (RAW12)
  yuyv,      // Y'CbCr 4:2:2: Y0 Cb Y1 Cr
  uyvy,      // Cb Y0 Cr Y1
  nv12,      // Y'CbCr 4:2:0: all Y', then Cb Cr of each 2 x 2 pixels
  jpeg       // one JPEG file an image
};

enum class BayerOrder { none, rg, gr, gb, bg };  // the first row's first two colours

struct PixelLayout {
  PixelPacking packing = PixelPacking::bytes;
  BayerOrder order = BayerOrder::none;
  int bits = 8;         // of a sample that mean something
  int stored_bits = 8;  // that hold a pixel on average; 0: differs from image to image
};
PixelLayout layout_of(PixelFormat format);
bool is_ycbcr(PixelFormat format);  // and needs a YcbcrCoding to become a picture

// How Y', Cb and Cr became numbers: Rec. ITU-R BT.601 or BT.709; limited: Y' 16 to 235, full: 0 to 255. A JPEG is
// bt601_full always (JFIF, ITU-T T.871).
enum class YcbcrCoding { bt601_limited, bt601_full, bt709_limited, bt709_full };
std::string_view to_string(YcbcrCoding coding);  // "bt601-limited"
std::optional<YcbcrCoding> ycbcr_coding_from(std::string_view name);

// Formats put several pixels in a group of bytes: width (and height, for nv12) must be a multiple of these.
struct PixelGroup {
  int across = 1, down = 1;
};
PixelGroup pixel_group(PixelFormat format);

std::size_t bytes_per_pixel(PixelFormat format);                      // whole bytes that hold one: 2 for 12 bits
std::size_t image_bytes(int width, int height, PixelFormat format);   // 0 for mjpeg: nobody knows before
std::string_view to_string(PixelFormat format);                       // "BayerRG8": the GenICam name where there is one
std::optional<PixelFormat> pixel_format_from(std::string_view name);  // nothing if we do not know it
std::vector<PixelFormat> pixel_formats();                             // all

// Shared, immutable pixels: whoever owns the memory (a vector, an Aravis buffer) stays alive as long as a copy.
struct Image {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
  std::shared_ptr<const std::uint8_t> pixels;
  YcbcrCoding ycbcr = YcbcrCoding::bt601_limited;  // of what is_ycbcr
  std::size_t jpeg_bytes = 0;                      // of mjpeg: the file's length

  std::size_t size_bytes() const {
    return format == PixelFormat::mjpeg ? jpeg_bytes : image_bytes(width, height, format);
  }
  std::span<const std::uint8_t> bytes() const { return {pixels.get(), pixels ? size_bytes() : 0}; }
};

// Takes ownership of `bytes`, which are one whole file for mjpeg; throws InvalidInput if there are fewer than the size
// asks for.
Image make_image(int width, int height, PixelFormat format, std::vector<std::uint8_t> bytes,
                 YcbcrCoding ycbcr = YcbcrCoding::bt601_limited);

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
  damaged,         // came cut short or spoilt
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
