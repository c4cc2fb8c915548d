#include "simulator/gige/device_registers.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "config/errors.h"
#include "simulator/gige/big_endian.h"
#include "simulator/gige/chunk_data.h"
#include "simulator/gige/genicam_xml.h"
#include "simulator/gige/gvsp.h"
#include "simulator/gige/zip_archive.h"

namespace rotunda::simulator {
namespace {

constexpr std::uint32_t kBootstrapEnd = 0x1000, kFeatureBegin = reg::kWidth;
constexpr std::uint32_t kAnything = std::numeric_limits<std::uint32_t>::max();

// GVCP capabilities: concatenation, WRITEMEM, PACKETRESEND, PENDING_ACK, ACTION, scheduled action, IEEE 1588,
// unconditional action, switchover, application's port and address, link speed, heartbeat disable, serial, user name.
constexpr std::uint32_t kCapabilities = 1U << 0 | 1U << 1 | 1U << 2 | 1U << 5 | 1U << 6 | 1U << 17 | 1U << 19 |
                                        1U << 20 | 1U << 21 | 1U << 27 | 1U << 28 | 1U << 29 | 1U << 30 | 1U << 31;
constexpr std::uint32_t kStandardIdsSupported = 1U << 30, kStreamSourcePortSupported = 1U << 31;
constexpr std::uint32_t kUnconditionalAction = 1U << 3;

enum Kept : std::uint8_t { no, in_user_sets };
enum While : std::uint8_t { any_time, idle_only };

// What clients may write, and the values each word takes. The table of the device's behaviour.
struct Writable {
  std::uint32_t address;
  std::uint32_t min = 0;
  std::uint32_t max = kAnything;
  Kept kept = no;
  While when = any_time;
};
constexpr std::array kWritable{Writable{reg::kUserName},
                               Writable{reg::kUserName + 4},
                               Writable{reg::kUserName + 8},
                               Writable{reg::kUserName + 12},
                               Writable{reg::kHeartbeatMs, 500, 60000},
                               Writable{reg::kTimestampControl, 0, 3},
                               Writable{reg::kGvcpConfiguration},
                               Writable{reg::kSwitchoverKey, 0, 0xFFFF},
                               Writable{reg::kGvspConfiguration, 0, kAnything, no, idle_only},
                               Writable{reg::kControlPrivilege},
                               Writable{reg::kHostPort, 0, 65535},
                               Writable{reg::kPacketSize, 0, kAnything, no, any_time},
                               Writable{reg::kPacketDelay, 0, kAnything, in_user_sets},
                               Writable{reg::kDestination},
                               Writable{reg::kStreamConfiguration, 0, 0},
                               Writable{reg::kWidth, 0, kAnything, in_user_sets, idle_only},
                               Writable{reg::kHeight, 0, kAnything, in_user_sets, idle_only},
                               Writable{reg::kOffsetX, 0, kAnything, in_user_sets, idle_only},
                               Writable{reg::kOffsetY, 0, kAnything, in_user_sets, idle_only},
                               Writable{reg::kPixelFormat, 0, kAnything, in_user_sets, idle_only},
                               Writable{reg::kAcquisitionMode, 0, 2, in_user_sets},
                               Writable{reg::kAcquisitionStart, 0, 1},
                               Writable{reg::kAcquisitionStop, 0, 1},
                               Writable{reg::kFrameCount, 1, 65535, in_user_sets},
                               Writable{reg::kFrameRate, 100, 1'000'000, in_user_sets},
                               Writable{reg::kFrameRateEnable, 0, 1, in_user_sets},
                               Writable{reg::kExposureTime, 1'000, 1'000'000'000, in_user_sets},
                               Writable{reg::kGain, 0, 2400, in_user_sets},
                               Writable{reg::kExposureMode, 0, 0},
                               Writable{reg::kBalanceSelector, 0, 2},
                               Writable{reg::kBalanceRatio, 1'000, 80'000, in_user_sets},
                               Writable{reg::kBalanceRatio + 4, 1'000, 80'000, in_user_sets},
                               Writable{reg::kBalanceRatio + 8, 1'000, 80'000, in_user_sets},
                               Writable{reg::kTriggerSelector, 0, 0},
                               Writable{reg::kTriggerMode, 0, 1, in_user_sets},
                               Writable{reg::kTriggerSource, 0, 2, in_user_sets},
                               Writable{reg::kTriggerActivation, 0, 2, in_user_sets},
                               Writable{reg::kTriggerSoftware, 0, 1},
                               Writable{reg::kTriggerDelay, 0, 1'000'000'000, in_user_sets},
                               Writable{reg::kLineSelector, 0, 0},
                               Writable{reg::kLineDebounce, 0, 10'000'000, in_user_sets},
                               Writable{reg::kActionSelector, 0, 0},
                               Writable{reg::kActionDeviceKey},
                               Writable{reg::kActionGroupKey, 0, kAnything, in_user_sets},
                               Writable{reg::kActionGroupMask, 0, kAnything, in_user_sets},
                               Writable{reg::kPtpEnable, 0, 1, in_user_sets},
                               Writable{reg::kPtpDataSetLatch, 0, 1},
                               Writable{reg::kTimestampLatch, 0, 1},
                               Writable{reg::kTimestampReset, 0, 1},
                               Writable{reg::kIndicator, 0, 1},
                               Writable{reg::kChunkModeActive, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kChunkSelector, 0, kChunks - 1},
                               Writable{reg::kChunkEnable, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kChunkEnable + 4, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kChunkEnable + 8, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kChunkEnable + 12, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kChunkEnable + 16, 0, 1, in_user_sets, idle_only},
                               Writable{reg::kUserSetSelector, 0, 2},
                               Writable{reg::kUserSetLoad, 0, 1, no, idle_only},
                               Writable{reg::kUserSetSave, 0, 1},
                               Writable{reg::kUserSetDefault, 0, 2},
                               Writable{reg::kTransmissionDelay, 0, 1'000'000'000, in_user_sets}};
static_assert(reg::kChunkEnable + 4 * (kChunks - 1) == reg::kChunkEnable + 16);

const Writable* row_of(std::uint32_t address) {
  const auto row = std::find_if(kWritable.begin(), kWritable.end(),
                                [address](const Writable& entry) { return entry.address == address; });
  return row == kWritable.end() ? nullptr : &*row;
}

std::uint32_t largest_step(std::uint32_t size) {
  return size % 4 == 0 ? 4 : size % 2 == 0 ? 2 : 1;
}

std::uint32_t ipv4(const GigeCameraOptions& options) {
  in_addr address{};
  if (inet_pton(AF_INET, options.address.c_str(), &address) != 1)
    throw InvalidInput(fmt::format("{}: \"{}\" is not an IPv4 address", options.name, options.address));
  return ntohl(address.s_addr);
}

}  // namespace

std::vector<capture::PixelFormat> selectable_formats(capture::PixelFormat native) {
  if (native == capture::PixelFormat::mono8 || capture::bytes_per_pixel(native) != 1) return {native};
  return {native, capture::PixelFormat::mono8};
}

RegionLimits region_limits(const GigeCameraOptions& options) {
  const auto width = static_cast<std::uint32_t>(options.width), height = static_cast<std::uint32_t>(options.height);
  return {.min_width = std::min(width, 16U),
          .min_height = std::min(height, 16U),
          .width_step = largest_step(width),
          .height_step = std::min(largest_step(height), 2U),
          .offset_step = 2};
}

DeviceRegisters::DeviceRegisters(const GigeCameraOptions& options)
    : bootstrap_(kBootstrapEnd), features_(reg::kFeatureEnd - kFeatureBegin) {
  if (options.width < 1 || options.height < 1 || options.width > 65535 || options.height > 65535)
    throw InvalidInput(fmt::format("{}: {} x {} is no picture", options.name, options.width, options.height));
  limits_ = region_limits(options);
  for (const auto format : selectable_formats(options.format)) pixel_codes_.push_back(pixel_code(format));
  description_ = zip_archive("rotunda.xml", genicam_xml(options));
  store_text(0x200, 512, fmt::format("Local:rotunda.zip;{:x};{:x}", reg::kDescription, description_.size()));
  description_.resize((description_.size() + 3) / 4 * 4);
  describe_device(options);
  describe_capabilities();
  describe_features(options);
}

void DeviceRegisters::describe_device(const GigeCameraOptions& options) {
  const auto& mac = options.mac;
  set(0x00, 2U << 16);    // GigE Vision 2.0
  set(0x04, 0x80000001);  // big-endian, UTF-8
  set(reg::kMacHigh, static_cast<std::uint32_t>(mac[0] << 8 | mac[1]));
  set(reg::kMacLow, load_be<std::uint32_t>(mac, 2));
  set(0x10, 0x5);  // IP configuration: persistent and link-local are supported
  set(0x14, 0x5);
  set(reg::kAddress, ipv4(options));
  set(0x34, 0xFF000000);  // subnet mask
  store_text(0x48, 32, "Rotunda");
  store_text(0x68, 32, "Simulated studio camera");
  store_text(0x88, 32, "1.0");
  store_text(0xA8, 48, "shows a synthetic studio; not a real device");
  store_text(0xD8, 16, options.serial);
  store_text(reg::kUserName, 16, options.name);
}

void DeviceRegisters::describe_capabilities() {
  set(0x600, 1);               // network interfaces
  set(reg::kLinkSpeed, 1000);  // Mb/s
  set(0x904, 1);               // stream channels
  set(0x908, 1);               // action signals
  set(0x910, 1);               // active links
  set(0x92C, kStreamSourcePortSupported | kStandardIdsSupported);
  set(0x934, kCapabilities);
  set(reg::kHeartbeatMs, 3000);
  set64(0x93C, 1'000'000'000);  // ticks a second
  set(reg::kGvcpConfiguration, kUnconditionalAction | kPendingAckEnable);
  set(reg::kPendingTimeoutMs, 2000);
  set(reg::kActionQueueSize, 16);
  set(reg::kPacketSize, 1500);
}

void DeviceRegisters::describe_features(const GigeCameraOptions& options) {
  const auto width = static_cast<std::uint32_t>(options.width), height = static_cast<std::uint32_t>(options.height);
  set(reg::kWidth, width);
  set(reg::kHeight, height);
  set(reg::kSensorWidth, width);
  set(reg::kSensorHeight, height);
  set(reg::kPixelFormat, pixel_code(options.format));
  for (std::uint32_t colour = 0; colour < 3; ++colour) set(reg::kBalanceRatio + 4 * colour, 10'000);
  for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) set(reg::kChunkEnable + 4 * chunk, chunk < 3);
  set(reg::kFrameCount, 1);
  set(reg::kFrameRate, 25'000);
  set(reg::kFrameRateEnable, 1);
  set(reg::kExposureTime, static_cast<std::uint32_t>(options.exposure_us * 1000.0));
  set(reg::kTriggerSource, static_cast<std::uint32_t>(TriggerSource::action1));
  set(reg::kActionGroupMask, 1);
  set(reg::kPtpEnable, options.clock.ptp);
  update_payload();
}

void DeviceRegisters::update_payload() {
  const auto pixels = picture_bytes(get(reg::kPixelFormat), get(reg::kWidth), get(reg::kHeight));
  const bool with_chunks = get(reg::kChunkModeActive) == 1;
  const auto chunks = with_chunks ? chunk_data_bytes(pixels, enabled_chunks()) : 0;
  set(reg::kPayloadSize, static_cast<std::uint32_t>(pixels + chunks));
}

ImageSettings DeviceRegisters::image_settings() const {
  return {get(reg::kExposureTime),
          get(reg::kGain),
          {get(reg::kBalanceRatio), get(reg::kBalanceRatio + 4), get(reg::kBalanceRatio + 8)}};
}

std::uint32_t DeviceRegisters::enabled_chunks() const {
  std::uint32_t enabled = 0;
  if (get(reg::kChunkModeActive) == 0) return 0;
  for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) enabled |= get(reg::kChunkEnable + 4 * chunk) << chunk;
  return enabled;
}

void DeviceRegisters::store_text(std::uint32_t address, std::size_t room, std::string_view text) {
  if (text.size() >= room)
    throw InvalidInput(fmt::format("\"{}\" is longer than the {} characters a camera keeps", text, room - 1));
  std::copy(text.begin(), text.end(), bootstrap_.begin() + address);
}

std::span<std::uint8_t> DeviceRegisters::word(std::uint32_t address) {
  const bool is_bootstrap = address < kBootstrapEnd;
  assert(address % 4 == 0 && (is_bootstrap || (address >= kFeatureBegin && address < reg::kFeatureEnd)));
  return is_bootstrap ? std::span{bootstrap_}.subspan(address, 4)
                      : std::span{features_}.subspan(address - kFeatureBegin, 4);
}

std::uint32_t DeviceRegisters::get(std::uint32_t address) const {
  return load_be<std::uint32_t>(const_cast<DeviceRegisters*>(this)->word(address), 0);
}

void DeviceRegisters::set(std::uint32_t address, std::uint32_t value) {
  store_be(word(address), 0, value);
}

void DeviceRegisters::set64(std::uint32_t address, std::uint64_t value) {
  set(address, static_cast<std::uint32_t>(value >> 32));
  set(address + 4, static_cast<std::uint32_t>(value));
}

std::optional<std::span<const std::uint8_t>> DeviceRegisters::read(std::uint32_t address, std::size_t bytes) const {
  struct Area {
    std::uint32_t begin;
    const std::vector<std::uint8_t>& memory;
  };
  for (const Area& area :
       {Area{0, bootstrap_}, Area{kFeatureBegin, features_}, Area{reg::kDescription, description_}}) {
    const std::size_t size = area.memory.size();
    if (address >= area.begin && address - area.begin < size && bytes <= size - (address - area.begin))
      return std::span{area.memory}.subspan(address - area.begin, bytes);
  }
  return std::nullopt;
}

GvcpStatus DeviceRegisters::write(std::uint32_t address, std::uint32_t value) {
  const auto status = check_value(address, value);
  if (status != GvcpStatus::success) return status;
  set(address, value);
  update_payload();
  return status;
}

GvcpStatus DeviceRegisters::check_value(std::uint32_t address, std::uint32_t value) const {
  const Writable* row = row_of(address);
  if (row == nullptr) return read(address, 4) ? GvcpStatus::write_protect : GvcpStatus::invalid_address;
  if (value < row->min || value > row->max) return GvcpStatus::invalid_parameter;
  if (address == reg::kPixelFormat && std::count(pixel_codes_.begin(), pixel_codes_.end(), value) == 0)
    return GvcpStatus::invalid_parameter;
  if (address == reg::kPacketSize) {
    const std::uint32_t size = value & kPacketSizeMask;
    if (size < kMinPacketSize || size > kMaxPacketSize) return GvcpStatus::invalid_parameter;
  }
  return fits_sensor(address, value) ? GvcpStatus::success : GvcpStatus::invalid_parameter;
}

bool DeviceRegisters::fits_sensor(std::uint32_t address, std::uint32_t value) const {
  const auto fits = [&](std::uint32_t least, std::uint32_t other, std::uint32_t sensor, std::uint32_t step) {
    return value >= least && value <= get(sensor) && value + get(other) <= get(sensor) && value % step == 0;
  };
  if (address == reg::kWidth) return fits(limits_.min_width, reg::kOffsetX, reg::kSensorWidth, limits_.width_step);
  if (address == reg::kHeight) return fits(limits_.min_height, reg::kOffsetY, reg::kSensorHeight, limits_.height_step);
  if (address == reg::kOffsetX) return fits(0, reg::kWidth, reg::kSensorWidth, limits_.offset_step);
  if (address == reg::kOffsetY) return fits(0, reg::kHeight, reg::kSensorHeight, limits_.offset_step);
  return true;
}

bool DeviceRegisters::is_locked_while_acquiring(std::uint32_t address) {
  const Writable* row = row_of(address);
  return row != nullptr && row->when == idle_only;
}

DeviceRegisters::Settings DeviceRegisters::settings() const {
  Settings settings;
  for (const auto& row : kWritable)
    if (row.kept == in_user_sets) settings[row.address] = get(row.address);
  return settings;
}

void DeviceRegisters::restore(const Settings& settings) {
  for (const auto& [address, value] : settings) set(address, value);
  update_payload();
}

}  // namespace rotunda::simulator
