#include "simulator/gige/genicam_xml.h"

#include <fmt/format.h>

#include "simulator/gige/chunk_data.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/genicam_writer.h"
#include "simulator/gige/gvsp.h"

namespace rotunda::simulator {
namespace {

constexpr std::int64_t kWord = 0xFFFFFFFF, kLong = 0x7FFFFFFFFFFFFFFF;

void list_categories(GenicamWriter& xml) {
  xml.category({"Root",
                {"DeviceControl", "ImageFormatControl", "AcquisitionControl", "AnalogControl", "DigitalIOControl",
                 "ActionControl", "PtpControl", "ChunkDataControl", "UserSetControl", "TransportLayerControl"}});
  xml.category({"DeviceControl",
                {"DeviceVendorName", "DeviceModelName", "DeviceVersion", "DeviceManufacturerInfo", "DeviceSerialNumber",
                 "DeviceUserID", "DeviceTemperature", "DeviceIndicatorMode", "TimestampLatch", "TimestampReset",
                 "TimestampLatchValue"}});
  xml.category({"ImageFormatControl",
                {"SensorWidth", "SensorHeight", "WidthMax", "HeightMax", "Width", "Height", "OffsetX", "OffsetY",
                 "PixelFormat"}});
  xml.category(
      {"AcquisitionControl",
       {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameCount", "AcquisitionFrameRate",
        "AcquisitionFrameRateEnable", "TriggerSelector", "TriggerMode", "TriggerSource", "TriggerActivation",
        "TriggerDelay", "TriggerSoftware", "ExposureMode", "ExposureTime"}});
  xml.category({"AnalogControl", {"Gain", "BalanceRatioSelector", "BalanceRatio"}});
  xml.category({"DigitalIOControl", {"LineSelector", "LineMode", "LineStatus", "LineStatusAll", "LineDebounceTime"}});
  xml.category({"ActionControl", {"ActionDeviceKey", "ActionSelector", "ActionGroupKey", "ActionGroupMask"}});
  xml.category({"PtpControl",
                {"PtpEnable", "PtpStatus", "PtpServoStatus", "PtpClockID", "PtpDataSetLatch", "PtpOffsetFromMaster",
                 "GevIEEE1588", "GevIEEE1588Status", "GevIEEE1588DataSetLatch", "GevIEEE1588OffsetFromMaster",
                 "GevIEEE1588ClockId"}});
  xml.category({"ChunkDataControl",
                {"ChunkModeActive", "ChunkSelector", "ChunkEnable", "ChunkTimestamp", "ChunkExposureTime",
                 "ChunkLineStatusAll", "ChunkFrameID", "ChunkGain"}});
  xml.category({"UserSetControl", {"UserSetSelector", "UserSetLoad", "UserSetSave", "UserSetDefault"}});
  xml.category({"TransportLayerControl",
                {"PayloadSize",
                 "GevSCPHostPort",
                 "GevSCPSPacketSize",
                 "GevSCPSFireTestPacket",
                 "GevSCPSDoNotFragment",
                 "GevSCPD",
                 "GevSCFTD",
                 "GevSCDA",
                 "GevGVSPExtendedIDMode",
                 "GevHeartbeatTimeout",
                 "GevGVCPHeartbeatDisable",
                 "GevGVCPPendingAck",
                 "GevGVCPPendingTimeout",
                 "GevCurrentIPAddress",
                 "GevPrimaryApplicationSocket",
                 "GevPrimaryApplicationIPAddress",
                 "GevTimestampControlLatch",
                 "GevTimestampControlReset",
                 "GevTimestampValue",
                 "GevTimestampTickFrequency"}});
}

void describe_device(GenicamWriter& xml) {
  xml.text("DeviceVendorName", 0x48, 32);
  xml.text("DeviceModelName", 0x68, 32);
  xml.text("DeviceVersion", 0x88, 32);
  xml.text("DeviceManufacturerInfo", 0xA8, 48);
  xml.text("DeviceSerialNumber", 0xD8, 16);
  xml.text("DeviceUserID", reg::kUserName, 16, "RW");
  xml.floating({"DeviceTemperature", reg::kTemperature, "RO", "C", 1000.0, 0.0, 120.0});
  xml.enumeration("DeviceIndicatorMode", reg::kIndicator, "RW", {{"Inactive", 0}, {"Active", 1}});
  xml.command("TimestampLatch", reg::kTimestampLatch);
  xml.command("TimestampReset", reg::kTimestampReset);
  xml.integer({"TimestampLatchValue", reg::kTimestampHigh, "RO", 0, kLong, 8, "Unsigned", 1, "ns"});
}

// What is left of the sensor beside the other of offset and size.
void rest_of_sensor(GenicamWriter& xml, std::string_view name, int sensor, std::string_view other) {
  xml.raw(
      fmt::format("<IntSwissKnife Name=\"{}\"><pVariable Name=\"OTHER\">{}Reg</pVariable><Formula>{} - OTHER</Formula>"
                  "</IntSwissKnife\n>",
                  name, other, sensor));
}

void describe_image(GenicamWriter& xml, const GigeCameraOptions& options) {
  const auto limits = region_limits(options);
  for (const auto name : {"SensorWidth", "WidthMax"})
    xml.integer({name, reg::kSensorWidth, "RO", options.width, options.width});
  for (const auto name : {"SensorHeight", "HeightMax"})
    xml.integer({name, reg::kSensorHeight, "RO", options.height, options.height});
  rest_of_sensor(xml, "WidthLimit", options.width, "OffsetX");
  rest_of_sensor(xml, "HeightLimit", options.height, "OffsetY");
  rest_of_sensor(xml, "OffsetXLimit", options.width, "Width");
  rest_of_sensor(xml, "OffsetYLimit", options.height, "Height");
  xml.integer({"Width", reg::kWidth, "RW", limits.min_width, 0, 4, "Unsigned", limits.width_step, "px", "WidthLimit"});
  xml.integer(
      {"Height", reg::kHeight, "RW", limits.min_height, 0, 4, "Unsigned", limits.height_step, "px", "HeightLimit"});
  xml.integer({"OffsetX", reg::kOffsetX, "RW", 0, 0, 4, "Unsigned", limits.offset_step, "px", "OffsetXLimit"});
  xml.integer({"OffsetY", reg::kOffsetY, "RW", 0, 0, 4, "Unsigned", limits.offset_step, "px", "OffsetYLimit"});
  std::vector<Entry> formats;
  for (const auto format : selectable_formats(options.format))
    formats.push_back({capture::to_string(format), pixel_code(format)});
  xml.enumeration("PixelFormat", reg::kPixelFormat, "RW", formats);
}

void describe_acquisition(GenicamWriter& xml) {
  xml.enumeration("AcquisitionMode", reg::kAcquisitionMode, "RW",
                  {{"Continuous", 0}, {"SingleFrame", 1}, {"MultiFrame", 2}});
  xml.command("AcquisitionStart", reg::kAcquisitionStart);
  xml.command("AcquisitionStop", reg::kAcquisitionStop);
  xml.integer({"AcquisitionFrameCount", reg::kFrameCount, "RW", 1, 65535});
  xml.floating({"AcquisitionFrameRate", reg::kFrameRate, "RW", "Hz", 1000.0, 0.1, 1000.0});
  xml.boolean("AcquisitionFrameRateEnable", reg::kFrameRateEnable);
  xml.enumeration("ExposureMode", reg::kExposureMode, "RW", {{"Timed", 0}});
  xml.floating({"ExposureTime", reg::kExposureTime, "RW", "us", 1000.0, 1.0, 1e6});
  xml.floating({"Gain", reg::kGain, "RW", "dB", 100.0, 0.0, 24.0});
  xml.selector("BalanceRatioSelector", reg::kBalanceSelector, {{"Red", 0}, {"Green", 1}, {"Blue", 2}},
               {"BalanceRatio"});
  xml.floating({"BalanceRatio", reg::kBalanceRatio, "RW", "", 10000.0, 0.1, 8.0, "BalanceRatioSelector"});
}

void describe_trigger(GenicamWriter& xml) {
  xml.enumeration("TriggerSelector", reg::kTriggerSelector, "RW", {{"FrameStart", 0}});
  xml.enumeration("TriggerMode", reg::kTriggerMode, "RW", {{"Off", 0}, {"On", 1}});
  xml.enumeration("TriggerSource", reg::kTriggerSource, "RW", {{"Software", 0}, {"Line0", 1}, {"Action1", 2}});
  xml.enumeration("TriggerActivation", reg::kTriggerActivation, "RW",
                  {{"RisingEdge", 0}, {"FallingEdge", 1}, {"AnyEdge", 2}});
  xml.floating({"TriggerDelay", reg::kTriggerDelay, "RW", "us", 1000.0, 0.0, 1e6});
  xml.command("TriggerSoftware", reg::kTriggerSoftware);
  xml.selector("LineSelector", reg::kLineSelector, {{"Line0", 0}}, {"LineMode", "LineStatus", "LineDebounceTime"});
  xml.enumeration("LineMode", reg::kLineMode, "RO", {{"Input", 0}});
  xml.integer({"LineStatusAll", reg::kLineStatus, "RO", 0, 1});
  xml.raw(
      "<Boolean Name=\"LineStatus\"><pValue>LineStatusAll</pValue>"
      "</Boolean\n>");
  xml.floating({"LineDebounceTime", reg::kLineDebounce, "RW", "us", 1000.0, 0.0, 10000.0});
  xml.integer({"ActionSelector", reg::kActionSelector, "RW", 0, 0});
  xml.integer({"ActionDeviceKey", reg::kActionDeviceKey, "RW", 0, kWord});
  xml.integer({"ActionGroupKey", reg::kActionGroupKey, "RW", 0, kWord});
  xml.integer({"ActionGroupMask", reg::kActionGroupMask, "RW", 0, kWord});
}

// By their names in SFNC 2.x and by those vendors used before it.
void describe_ptp(GenicamWriter& xml) {
  for (const auto name : {"PtpEnable", "GevIEEE1588"}) xml.boolean(name, reg::kPtpEnable);
  for (const auto name : {"PtpStatus", "GevIEEE1588Status"})
    xml.enumeration(name, reg::kPtpStatus, "RO",
                    {{"Initializing", 1},
                     {"Faulty", 2},
                     {"Disabled", 3},
                     {"Listening", 4},
                     {"PreMaster", 5},
                     {"Master", 6},
                     {"Passive", 7},
                     {"Uncalibrated", 8},
                     {"Slave", 9}});
  xml.enumeration("PtpServoStatus", reg::kPtpServoStatus, "RO", {{"Unlocked", 0}, {"Locked", 1}});
  for (const auto name : {"PtpDataSetLatch", "GevIEEE1588DataSetLatch"}) xml.command(name, reg::kPtpDataSetLatch);
  for (const auto name : {"PtpOffsetFromMaster", "GevIEEE1588OffsetFromMaster"})
    xml.integer({name, reg::kPtpOffset, "RO", -kLong, kLong, 8, "Signed", 1, "ns"});
  for (const auto name : {"PtpClockID", "GevIEEE1588ClockId"}) xml.integer({name, reg::kPtpClockId, "RO", 0, kLong, 8});
  xml.command("GevTimestampControlLatch", reg::kTimestampControl, 2);
  xml.command("GevTimestampControlReset", reg::kTimestampControl, 1);
  xml.integer({"GevTimestampValue", reg::kTimestampHigh, "RO", 0, kLong, 8, "Unsigned", 1, "ns"});
  xml.integer({"GevTimestampTickFrequency", 0x93C, "RO", 0, kLong, 8, "Unsigned", 1, "Hz"});
}

// A port that is one chunk of the frame at hand, and the register at its beginning.
void chunk_register(GenicamWriter& xml, std::string_view name, Chunk chunk, int bytes) {
  xml.raw(
      fmt::format("<IntReg Name=\"{0}Reg\"><Address>0x0</Address><Length>{1}</Length><AccessMode>RO</AccessMode>"
                  "<pPort>{0}Port</pPort><Cachable>NoCache</Cachable><Endianess>BigEndian</Endianess></IntReg\n>"
                  "<Port Name=\"{0}Port\"><ChunkID>{2:x}</ChunkID></Port\n>",
                  name, bytes, chunk_id(chunk)));
}

void chunk_integer(GenicamWriter& xml, std::string_view name, Chunk chunk, int bytes) {
  xml.raw(fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue></Integer\n>", name));
  chunk_register(xml, name, chunk, bytes);
}

void chunk_float(GenicamWriter& xml, std::string_view name, Chunk chunk, std::string_view unit, double scale) {
  xml.raw(
      fmt::format("<Float Name=\"{0}\"><pValue>{0}Scaled</pValue><Unit>{1}</Unit></Float\n>"
                  "<Converter Name=\"{0}Scaled\"><FormulaTo>FROM * {2}</FormulaTo><FormulaFrom>TO / {2}</FormulaFrom>"
                  "<pValue>{0}Reg</pValue><Slope>Increasing</Slope></Converter\n>",
                  name, unit, scale));
  chunk_register(xml, name, chunk, 4);
}

void describe_chunks(GenicamWriter& xml) {
  xml.boolean("ChunkModeActive", reg::kChunkModeActive);
  xml.selector("ChunkSelector", reg::kChunkSelector,
               {{"Timestamp", 0}, {"ExposureTime", 1}, {"LineStatusAll", 2}, {"FrameID", 3}, {"Gain", 4}},
               {"ChunkEnable"});
  xml.boolean("ChunkEnable", reg::kChunkEnable, "ChunkSelector");
  chunk_integer(xml, "ChunkTimestamp", Chunk::timestamp, 8);
  chunk_float(xml, "ChunkExposureTime", Chunk::exposure_time, "us", 1000.0);
  chunk_integer(xml, "ChunkLineStatusAll", Chunk::line_status_all, 4);
  chunk_integer(xml, "ChunkFrameID", Chunk::frame_id, 8);
  chunk_float(xml, "ChunkGain", Chunk::gain, "dB", 100.0);
}

void describe_user_sets(GenicamWriter& xml) {
  const std::vector<Entry> sets{{"Default", 0}, {"UserSet0", 1}, {"UserSet1", 2}};
  xml.selector("UserSetSelector", reg::kUserSetSelector, sets, {"UserSetLoad", "UserSetSave"});
  xml.command("UserSetLoad", reg::kUserSetLoad);
  xml.command("UserSetSave", reg::kUserSetSave);
  xml.enumeration("UserSetDefault", reg::kUserSetDefault, "RW", sets);
}

// One bit of a word of switches.
void switch_bit(GenicamWriter& xml, std::string_view name, std::uint32_t address, int bit) {
  xml.bits(name, address, bit, bit);
  xml.raw(fmt::format("<Boolean Name=\"{0}\"><pValue>{0}Reg</pValue></Boolean\n>", name));
}

void describe_transport(GenicamWriter& xml) {
  xml.integer({"PayloadSize", reg::kPayloadSize, "RO", 0, kWord, 4, "Unsigned", 1, "B"});
  xml.integer({"GevSCPHostPort", reg::kHostPort, "RW", 0, 65535});
  xml.masked_integer("GevSCPSPacketSize", reg::kPacketSize, 16, 31, kMinPacketSize, kMaxPacketSize);
  xml.bits("GevSCPSFireTestPacket", reg::kPacketSize, 0, 0);
  xml.raw(
      "<Command Name=\"GevSCPSFireTestPacket\"><pValue>GevSCPSFireTestPacketReg</pValue>"
      "<CommandValue>1</CommandValue></Command\n>");
  switch_bit(xml, "GevSCPSDoNotFragment", reg::kPacketSize, 1);
  xml.integer({"GevSCPD", reg::kPacketDelay, "RW", 0, kWord, 4, "Unsigned", 1, "ns"});
  xml.integer({"GevSCFTD", reg::kTransmissionDelay, "RW", 0, 1'000'000'000, 4, "Unsigned", 1, "ns"});
  xml.integer({"GevSCDA", reg::kDestination, "RW", 0, kWord});
  xml.bits("GevGVSPExtendedIDMode", reg::kGvspConfiguration, 1, 1);
  xml.raw(
      "<Enumeration Name=\"GevGVSPExtendedIDMode\"><EnumEntry Name=\"Off\"><Value>0</Value></EnumEntry>"
      "<EnumEntry Name=\"On\"><Value>1</Value></EnumEntry><pValue>GevGVSPExtendedIDModeReg</pValue></Enumeration\n>");
  xml.integer({"GevHeartbeatTimeout", reg::kHeartbeatMs, "RW", 500, 60000, 4, "Unsigned", 1, "ms"});
  switch_bit(xml, "GevGVCPHeartbeatDisable", reg::kGvcpConfiguration, 31);
  switch_bit(xml, "GevGVCPPendingAck", reg::kGvcpConfiguration, 30);
  xml.integer({"GevGVCPPendingTimeout", reg::kPendingTimeoutMs, "RO", 0, kWord, 4, "Unsigned", 1, "ms"});
  xml.integer({"GevCurrentIPAddress", reg::kAddress, "RO", 0, kWord});
  xml.integer({"GevPrimaryApplicationSocket", reg::kPrimaryPort, "RO", 0, 65535});
  xml.integer({"GevPrimaryApplicationIPAddress", reg::kPrimaryAddress, "RO", 0, kWord});
  xml.raw(
      "<Integer "
      "Name=\"TLParamsLocked\"><Visibility>Invisible</Visibility><Value>0</Value><Min>0</Min><Max>1</Max></Integer\n>");
}

}  // namespace

std::string genicam_xml(const GigeCameraOptions& options) {
  GenicamWriter xml;
  list_categories(xml);
  describe_device(xml);
  describe_image(xml, options);
  describe_acquisition(xml);
  describe_trigger(xml);
  describe_ptp(xml);
  describe_chunks(xml);
  describe_user_sets(xml);
  describe_transport(xml);
  return std::move(xml).finished();
}

}  // namespace rotunda::simulator
