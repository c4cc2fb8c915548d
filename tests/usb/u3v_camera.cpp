#include "tests/usb/u3v_camera.h"

#include <algorithm>
#include <array>
#include <utility>

#include "simulator/gige/genicam_writer.h"

namespace rotunda::tests {
namespace {

// Technology agnostic bootstrap registers (GenCP 1.1, table 4-1).
constexpr std::uint64_t kVersion = 0x0, kManufacturer = 0x4, kModel = 0x44, kFamily = 0x84, kDeviceVersion = 0xC4,
                        kSerial = 0x144, kResponseTime = 0x1CC, kManifestAddress = 0x1D0, kSbrmAddress = 0x1D8;
// USB3 Vision's own (SBRM) and its stream interface's (SIRM).
constexpr std::uint64_t kSbrm = 0x1000, kMaxCommand = kSbrm + 0x14, kMaxAcknowledge = kSbrm + 0x18,
                        kStreamChannels = kSbrm + 0x1C, kSirmAddress = kSbrm + 0x20, kSirmLength = kSbrm + 0x28;
constexpr std::uint64_t kSirm = 0x2000, kStreamControl = kSirm + 0x4, kRequiredPayload = kSirm + 0x8,
                        kRequiredLeader = kSirm + 0x10, kRequiredTrailer = kSirm + 0x14, kPayloadSize = kSirm + 0x1C;
constexpr std::uint64_t kManifest = 0x3000, kDescription = 0x8000, kMemory = 0x20000;
constexpr std::uint32_t kMostTransfer = 0x1000;  // bytes of a command or acknowledge

// The camera's own.
constexpr std::uint32_t kWidth = 0x4000, kHeight = 0x4004, kOffsetX = 0x4008, kOffsetY = 0x400C, kFormat = 0x4010,
                        kPayload = 0x4014, kMode = 0x4018, kStart = 0x401C, kStop = 0x4020, kRate = 0x4024,
                        kExposure = 0x4028, kGain = 0x402C, kTriggerSelector = 0x4030, kTriggerMode = 0x4034,
                        kTriggerSource = 0x4038, kTriggerSoftware = 0x403C, kTriggerActivation = 0x4040,
                        kTemperature = 0x4044, kLatch = 0x4048, kLatched = 0x4050;
constexpr std::uint32_t kMono8 = 0x01080001;
constexpr int kSourceSoftware = 0;

constexpr std::uint32_t kCommandMagic = 0x43563355, kLeaderMagic = 0x4C563355, kTrailerMagic = 0x54563355;
constexpr std::size_t kHeader = 12, kOperand = 8;  // bytes of a command's header, and of the address behind it
constexpr std::uint16_t kReadMemory = 0x0800, kWriteMemory = 0x0802;
constexpr std::uint16_t kInvalidAddress = 0x8003, kNotImplemented = 0x8001;
constexpr unsigned kGuidString = 4;

void append(Bytes& bytes, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

std::uint64_t number(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= static_cast<std::uint64_t>(bytes[at + i]) << (8 * i);
  return value;
}

std::uint64_t host_nanoseconds() {
  return static_cast<std::uint64_t>(
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count());
}

std::string description(const U3vCameraOptions& options) {
  simulator::GenicamWriter xml;
  xml.category({"Root", {"DeviceControl", "ImageFormatControl", "AcquisitionControl"}});
  xml.category({"DeviceControl",
                {"DeviceVendorName", "DeviceModelName", "DeviceSerialNumber", "DeviceTemperature", "TimestampLatch",
                 "TimestampLatchValue"}});
  xml.category({"ImageFormatControl", {"Width", "Height", "OffsetX", "OffsetY", "PixelFormat", "PayloadSize"}});
  xml.category({"AcquisitionControl",
                {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameRate", "ExposureTime",
                 "Gain", "TriggerSelector", "TriggerMode", "TriggerSource", "TriggerActivation", "TriggerSoftware"}});
  xml.text("DeviceVendorName", kManufacturer, 64);
  xml.text("DeviceModelName", kModel, 64);
  xml.text("DeviceSerialNumber", kSerial, 64);
  xml.floating({"DeviceTemperature", kTemperature, "RO", "C", 1000.0, 0.0, 120.0});
  xml.command("TimestampLatch", kLatch);
  xml.integer({"TimestampLatchValue", kLatched, "RO", 0, 0x7FFFFFFFFFFFFFFF, 8, "Unsigned", 1, "ns"});
  xml.integer({"Width", kWidth, "RW", 8, options.width, 4, "Unsigned", 8});
  xml.integer({"Height", kHeight, "RW", 8, options.height, 4, "Unsigned", 8});
  xml.integer({"OffsetX", kOffsetX, "RW", 0, 0});
  xml.integer({"OffsetY", kOffsetY, "RW", 0, 0});
  xml.enumeration("PixelFormat", kFormat, "RW", {{"Mono8", kMono8}});
  xml.integer({"PayloadSize", kPayload, "RO", 0, 0xFFFFFFFF});
  xml.enumeration("AcquisitionMode", kMode, "RW", {{"Continuous", 0}});
  xml.command("AcquisitionStart", kStart);
  xml.command("AcquisitionStop", kStop);
  xml.floating({"AcquisitionFrameRate", kRate, "RW", "Hz", 1000.0, 0.1, 1000.0});
  xml.floating({"ExposureTime", kExposure, "RW", "us", 1000.0, 10.0, 1e6});
  xml.floating({"Gain", kGain, "RW", "dB", 100.0, 0.0, 24.0});
  xml.enumeration("TriggerSelector", kTriggerSelector, "RW", {{"FrameStart", 0}});
  xml.enumeration("TriggerMode", kTriggerMode, "RW", {{"Off", 0}, {"On", 1}});
  xml.enumeration("TriggerSource", kTriggerSource, "RW", {{"Software", kSourceSoftware}, {"Line0", 1}});
  xml.enumeration("TriggerActivation", kTriggerActivation, "RW", {{"RisingEdge", 0}});
  xml.command("TriggerSoftware", kTriggerSoftware);
  return std::move(xml).finished();
}

Bytes utf16_descriptor(const std::string& text) {
  Bytes descriptor{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char c : text) append(descriptor, static_cast<unsigned char>(c), 2);
  return descriptor;
}

void append_endpoint(Bytes& bytes, std::uint8_t address, std::uint16_t packet_bytes) {
  bytes.insert(bytes.end(), {7, 5, address, 2});  // bulk
  append(bytes, packet_bytes, 2);
  bytes.push_back(0);
}

}  // namespace

U3vCamera::U3vCamera(const U3vCameraOptions& options) : options_(options) {
  power_up();
}

void U3vCamera::power_up() {
  const std::lock_guard lock(mutex_);
  memory_.assign(kMemory, 0);
  acquiring_ = triggered_ = false;
  frames_ = 0;
  describe_itself();
}

void U3vCamera::describe_itself() {
  put(kVersion, 0x00010001, 4);
  put_text(kManufacturer, "Rotunda");
  put_text(kModel, "U3V test camera");
  put_text(kFamily, "Tests");
  put_text(kDeviceVersion, "1");
  put_text(kSerial, options_.serial);
  put(kResponseTime, 2000, 4);  // ms; asked anew sooner, a software trigger on a busy machine would be two
  put(kManifestAddress, kManifest, 8);
  put(kSbrmAddress, kSbrm, 8);
  put(kMaxCommand, kMostTransfer, 4);
  put(kMaxAcknowledge, kMostTransfer, 4);
  put(kStreamChannels, 1, 4);
  put(kSirmAddress, kSirm, 8);
  put(kSirmLength, 0x30, 4);
  put(kRequiredLeader, leader().size(), 4);
  put(kRequiredTrailer, trailer(0).size(), 4);
  const std::string xml = description(options_);
  put(kManifest, 1, 8);               // entries
  put(kManifest + 8, 0x01000000, 4);  // file version 1.0.0; the schema word 0 says: not compressed
  put(kManifest + 16, kDescription, 8);
  put(kManifest + 24, xml.size(), 8);
  std::copy(xml.begin(), xml.end(), memory_.begin() + kDescription);
  set_camera_register(kWidth, static_cast<std::uint32_t>(options_.width));
  set_camera_register(kHeight, static_cast<std::uint32_t>(options_.height));
  set_camera_register(kFormat, kMono8);
  set_camera_register(kRate, 10'000);
  set_camera_register(kExposure, 1'000'000);
  set_camera_register(kTemperature, 41'500);
  written(kWidth);
}

Bytes U3vCamera::device_descriptor() const {
  Bytes bytes{18, 1, 0, 2, 0xEF, 2, 1, 64};  // USB 2.0; miscellaneous, with interface associations
  append(bytes, kVendor, 2);
  append(bytes, kProduct, 2);
  append(bytes, 0x0100, 2);
  bytes.insert(bytes.end(), {1, 2, 3, 1});  // strings: manufacturer, product, serial number; one configuration
  return bytes;
}

Bytes U3vCamera::configuration(std::uint16_t packet_bytes) const {
  Bytes bytes{9, 2, 0, 0, 2, 1, 0, 0x80, 50};                        // two interfaces
  bytes.insert(bytes.end(), {8, 11, 0, 2, 0xEF, 5, 0, 0});           // they belong together
  bytes.insert(bytes.end(), {9, 4, 0, 0, 2, 0xEF, 5, 0, 0});         // control
  bytes.insert(bytes.end(), {20, 0x24, 1});                          // device info (USB3 Vision 1.0.1, table 3-3)
  append(bytes, 0x00010001, 4);                                      // GenCP
  append(bytes, 0x00010000, 4);                                      // USB3 Vision
  bytes.insert(bytes.end(), {kGuidString, 1, 2, 0, 0, 0, 3, 0, 4});  // strings; high speed
  append_endpoint(bytes, kControlIn, packet_bytes);
  append_endpoint(bytes, kControlOut, packet_bytes);
  bytes.insert(bytes.end(), {9, 4, 1, 0, 1, 0xEF, 5, 2, 0});  // streaming
  append_endpoint(bytes, kStreamIn, packet_bytes);
  bytes[2] = static_cast<std::uint8_t>(bytes.size());
  bytes[3] = static_cast<std::uint8_t>(bytes.size() >> 8U);
  return bytes;
}

Bytes U3vCamera::string_descriptor(unsigned number) const {
  const std::array<std::string, 5> texts{"", "Rotunda", "U3V test camera", options_.serial, "1209" + options_.serial};
  if (number == 0) return {4, 3, 9, 4};  // English
  return number < texts.size() ? utf16_descriptor(texts[number]) : Bytes{};
}

void U3vCamera::put(std::uint64_t address, std::uint64_t value, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) memory_[address + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t U3vCamera::get(std::uint64_t address, std::size_t bytes) const {
  return number(memory_, address, bytes);
}

void U3vCamera::put_text(std::uint64_t address, const std::string& text) {
  std::copy(text.begin(), text.end(), memory_.begin() + static_cast<std::ptrdiff_t>(address));
}

std::uint32_t U3vCamera::camera_register(std::uint32_t address) const {
  return __builtin_bswap32(static_cast<std::uint32_t>(get(address, 4)));
}

void U3vCamera::set_camera_register(std::uint32_t address, std::uint32_t value) {
  put(address, __builtin_bswap32(value), 4);
}

bool U3vCamera::fits(std::uint64_t address, std::size_t bytes) const {
  return address <= memory_.size() && bytes <= memory_.size() - address;
}

Bytes U3vCamera::answer(std::span<const std::uint8_t> command) {
  if (command.size() < kHeader + kOperand || number(command, 0, 4) != kCommandMagic) return {};
  const auto opcode = static_cast<std::uint16_t>(number(command, 6, 2));
  const std::lock_guard lock(mutex_);
  const auto [status, data] = obey(opcode, command.subspan(kHeader));
  Bytes acknowledge;
  append(acknowledge, kCommandMagic, 4);
  append(acknowledge, status, 2);
  append(acknowledge, opcode + 1U, 2);
  append(acknowledge, data.size(), 2);
  append(acknowledge, number(command, 10, 2), 2);
  acknowledge.insert(acknowledge.end(), data.begin(), data.end());
  return acknowledge;
}

U3vCamera::Answer U3vCamera::obey(std::uint16_t opcode, std::span<const std::uint8_t> operands) {
  const std::uint64_t address = number(operands, 0, kOperand);
  if (opcode == kReadMemory && operands.size() >= kOperand + 4) return read(address, number(operands, kOperand + 2, 2));
  if (opcode == kWriteMemory) return write(address, operands.subspan(kOperand));
  return {kNotImplemented, {}};
}

U3vCamera::Answer U3vCamera::read(std::uint64_t address, std::size_t bytes) const {
  if (!fits(address, bytes)) return {kInvalidAddress, {}};
  const auto from = memory_.begin() + static_cast<std::ptrdiff_t>(address);
  return {0, Bytes(from, from + static_cast<std::ptrdiff_t>(bytes))};
}

U3vCamera::Answer U3vCamera::write(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  if (!fits(address, bytes.size())) return {kInvalidAddress, {}};
  std::copy(bytes.begin(), bytes.end(), memory_.begin() + static_cast<std::ptrdiff_t>(address));
  written(address);
  Answer answer;
  append(answer.data, 0, 2);
  append(answer.data, bytes.size(), 2);
  return answer;
}

// What writing a register does beside.
void U3vCamera::written(std::uint64_t address) {
  if (address == kWidth || address == kHeight) {
    const std::uint32_t payload = camera_register(kWidth) * camera_register(kHeight);
    set_camera_register(kPayload, payload);
    put(kRequiredPayload, payload, 8);
  }
  if (address == kStart) {
    acquiring_ = true;
    triggered_ = false;
    frames_ = 0;
    next_ = std::chrono::steady_clock::now();
  }
  if (address == kStop) acquiring_ = false;
  if (address == kTriggerSoftware && camera_register(kTriggerSource) == kSourceSoftware) triggered_ = true;
  if (address == kLatch) {
    const std::uint64_t now = host_nanoseconds();
    set_camera_register(kLatched, static_cast<std::uint32_t>(now >> 32U));
    set_camera_register(kLatched + 4, static_cast<std::uint32_t>(now));
  }
}

bool U3vCamera::stream_enabled() const {
  const std::lock_guard lock(mutex_);
  return get(kStreamControl, 4) != 0;
}

bool U3vCamera::due() {
  if (!acquiring_ || get(kStreamControl, 4) == 0) return false;
  if (camera_register(kTriggerMode) != 0) return std::exchange(triggered_, false);
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return false;
  next_ = std::max(next_ + std::chrono::nanoseconds(1'000'000'000'000 / camera_register(kRate)), now);
  return true;
}

Bytes U3vCamera::leader() const {
  Bytes bytes;
  append(bytes, kLeaderMagic, 4);
  append(bytes, 0, 2);
  append(bytes, 52, 2);
  append(bytes, frames_, 8);
  append(bytes, 0, 2);
  append(bytes, 1, 2);  // an image
  append(bytes, host_nanoseconds(), 8);
  append(bytes, kMono8, 4);
  append(bytes, camera_register(kWidth), 4);
  append(bytes, camera_register(kHeight), 4);
  append(bytes, 0, 8);  // offsets
  append(bytes, 0, 4);  // padding
  return bytes;
}

Bytes U3vCamera::trailer(std::size_t payload) const {
  Bytes bytes;
  append(bytes, kTrailerMagic, 4);
  append(bytes, 0, 2);
  append(bytes, 32, 2);
  append(bytes, frames_, 8);
  append(bytes, 0, 4);  // status: all well
  append(bytes, payload, 8);
  append(bytes, camera_register(kHeight), 4);
  return bytes;
}

std::vector<Bytes> U3vCamera::next_frame() {
  const std::lock_guard lock(mutex_);
  if (!due()) return {};
  const int width = static_cast<int>(camera_register(kWidth)), height = static_cast<int>(camera_register(kHeight));
  Bytes pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixels.push_back(pixel(frames_, x, y));
  std::vector<Bytes> transfers{leader()};
  const std::size_t most = std::max<std::size_t>(get(kPayloadSize, 4), 1);
  for (std::size_t at = 0; at < pixels.size(); at += most)
    transfers.emplace_back(pixels.begin() + static_cast<std::ptrdiff_t>(at),
                           pixels.begin() + static_cast<std::ptrdiff_t>(std::min(at + most, pixels.size())));
  transfers.push_back(trailer(pixels.size()));
  ++frames_;
  return transfers;
}

}  // namespace rotunda::tests
