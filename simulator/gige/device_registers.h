#pragma once
// The memory of one camera as GVCP sees it: bootstrap registers (GigE Vision 2.x, chapter "Bootstrap registers"), our
// own feature registers, and the GenICam file. 32-bit words, big-endian. It checks addresses, access and ranges; what
// a write sets in motion is GigeDevice's part, the same for WRITEREG and WRITEMEM.
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "simulator/gige/camera_options.h"
#include "simulator/gige/gvcp.h"

namespace rotunda::simulator {

// Byte addresses.
namespace reg {
// bootstrap
inline constexpr std::uint32_t kMacHigh = 0x08, kMacLow = 0x0C, kAddress = 0x24, kUserName = 0xE8, kLinkSpeed = 0x670;
inline constexpr std::uint32_t kHeartbeatMs = 0x938, kTimestampControl = 0x944, kTimestampHigh = 0x948,
                               kTimestampLow = 0x94C, kGvcpConfiguration = 0x954, kPendingTimeoutMs = 0x958,
                               kSwitchoverKey = 0x95C, kGvspConfiguration = 0x960, kPtpPortState = 0x96C,
                               kActionQueueSize = 0x970, kControlPrivilege = 0xA00, kPrimaryPort = 0xA04,
                               kPrimaryAddress = 0xA14;
inline constexpr std::uint32_t kHostPort = 0xD00, kPacketSize = 0xD04, kPacketDelay = 0xD08, kDestination = 0xD18,
                               kSourcePort = 0xD1C, kStreamCapability = 0xD20, kStreamConfiguration = 0xD24;
// image
inline constexpr std::uint32_t kWidth = 0x10000, kHeight = 0x10004, kPixelFormat = 0x10008, kPayloadSize = 0x1000C,
                               kOffsetX = 0x10010, kOffsetY = 0x10014, kSensorWidth = 0x10018, kSensorHeight = 0x1001C;
// acquisition; exposure in ns, frame rate in mHz, gain in 0.01 dB, balance ratios (red, green, blue) in 0.0001
inline constexpr std::uint32_t kAcquisitionMode = 0x10100, kAcquisitionStart = 0x10104, kAcquisitionStop = 0x10108,
                               kFrameCount = 0x1010C, kFrameRate = 0x10110, kFrameRateEnable = 0x10114,
                               kExposureTime = 0x10118, kGain = 0x1011C, kExposureMode = 0x10120,
                               kBalanceSelector = 0x10124, kBalanceRatio = 0x10130;
// trigger and its line; delays in ns
inline constexpr std::uint32_t kTriggerSelector = 0x10200, kTriggerMode = 0x10204, kTriggerSource = 0x10208,
                               kTriggerActivation = 0x1020C, kTriggerSoftware = 0x10210, kTriggerDelay = 0x10214,
                               kLineSelector = 0x10220, kLineMode = 0x10224, kLineStatus = 0x10228,
                               kLineDebounce = 0x1022C;
// action
inline constexpr std::uint32_t kActionSelector = 0x10300, kActionDeviceKey = 0x10304, kActionGroupKey = 0x10308,
                               kActionGroupMask = 0x1030C;
// clock and health; the offset is a signed 64-bit word in ns, the temperature is in 0.001 degrees Celsius
inline constexpr std::uint32_t kPtpEnable = 0x10400, kPtpStatus = 0x10404, kPtpDataSetLatch = 0x10408,
                               kPtpOffset = 0x10410, kTimestampLatch = 0x10418, kTimestampReset = 0x1041C,
                               kPtpServoStatus = 0x10420, kPtpClockId = 0x10428, kTemperature = 0x10500,
                               kIndicator = 0x10504;
// chunks: kChunkEnable is a word a chunk
inline constexpr std::uint32_t kChunkModeActive = 0x10600, kChunkSelector = 0x10604, kChunkEnable = 0x10610;
inline constexpr std::uint32_t kUserSetSelector = 0x10700, kUserSetLoad = 0x10704, kUserSetSave = 0x10708,
                               kUserSetDefault = 0x1070C;
inline constexpr std::uint32_t kTransmissionDelay = 0x10800;  // GevSCFTD, ns
inline constexpr std::uint32_t kFeatureEnd = 0x10900;
inline constexpr std::uint32_t kDescription = 0x200000;
}  // namespace reg

enum class AcquisitionMode : std::uint32_t { continuous = 0, single_frame = 1, multi_frame = 2 };
enum class TriggerSource : std::uint32_t { software = 0, line0 = 1, action1 = 2 };

inline constexpr std::uint32_t kFireTestPacket = 1U << 31, kDoNotFragment = 1U << 30, kPacketSizeMask = 0xFFFF;
// Bits of kGvcpConfiguration and kGvspConfiguration.
inline constexpr std::uint32_t kHeartbeatDisable = 1U << 0, kPendingAckEnable = 1U << 1, kPtpConfigured = 1U << 19;
inline constexpr std::uint32_t kExtendedIdEnable = 1U << 30;

// What a client sets that changes pixels, in the registers' units.
struct ImageSettings {
  std::uint32_t exposure_ns = 0;
  std::uint32_t gain = 0;                      // 0.01 dB
  std::array<std::uint32_t, 3> balance_ratio;  // red, green, blue, 0.0001
  bool operator==(const ImageSettings&) const = default;
};

// Where a region may begin and how large it may be: pixels.
struct RegionLimits {
  std::uint32_t min_width, min_height, width_step, height_step;
  std::uint32_t offset_step;  // whole mosaic cells
};
RegionLimits region_limits(const GigeCameraOptions& options);

class DeviceRegisters {
 public:
  // Throws InvalidInput if the options do not fit the registers (names too long, no picture, no IPv4 address).
  explicit DeviceRegisters(const GigeCameraOptions& options);

  // The camera's own view: any implemented word, no access check. An address outside is a mistake in this program.
  std::uint32_t get(std::uint32_t address) const;
  void set(std::uint32_t address, std::uint32_t value);
  void set64(std::uint32_t address, std::uint64_t value);

  // The client's view. Reads give nothing where there is no memory; addresses and sizes are multiples of 4.
  std::optional<std::span<const std::uint8_t>> read(std::uint32_t address, std::size_t bytes) const;
  GvcpStatus write(std::uint32_t address, std::uint32_t value);
  static bool is_locked_while_acquiring(std::uint32_t address);

  // What a user set keeps: address and value of every setting. restore() takes what settings() gave.
  using Settings = std::map<std::uint32_t, std::uint32_t>;
  Settings settings() const;
  void restore(const Settings& settings);
  ImageSettings image_settings() const;
  std::uint32_t enabled_chunks() const;  // bit n: chunk n; 0 without chunk mode

  std::span<const std::uint8_t> discovery() const { return std::span{bootstrap_}.first(0xF8); }

 private:
  std::span<std::uint8_t> word(std::uint32_t address);
  void describe_device(const GigeCameraOptions& options);
  void describe_capabilities();
  void update_payload();
  GvcpStatus check_value(std::uint32_t address, std::uint32_t value) const;
  bool fits_sensor(std::uint32_t address, std::uint32_t value) const;
  void describe_features(const GigeCameraOptions& options);
  void store_text(std::uint32_t address, std::size_t room, std::string_view text);

  RegionLimits limits_{};
  std::vector<std::uint8_t> bootstrap_, features_, description_;
  std::vector<std::uint32_t> pixel_codes_;  // formats that may be asked for
};

// Formats a camera can be switched to: its own, and Mono8 (the mosaic's samples as they are) if that is 8 bits a pixel.
std::vector<capture::PixelFormat> selectable_formats(capture::PixelFormat native);

}  // namespace rotunda::simulator
