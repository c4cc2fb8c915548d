#include "simulator/gige/genicam_xml.h"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "simulator/gige/device_registers.h"
#include "simulator/gige/gvsp.h"

namespace rotunda::simulator {
namespace {

// One number of the camera: a register, and the node that shows it.
struct IntegerFeature {
  std::string_view name;
  std::uint32_t address;
  std::string_view access;
  std::int64_t min, max;
  int bytes = 4;
  std::string_view sign = "Unsigned";
};

// A number with a unit: the register holds round(value * scale).
struct FloatFeature {
  std::string_view name;
  std::uint32_t address;
  std::string_view access, unit;
  double scale, min, max;
};

struct Entry {
  std::string_view name;
  std::uint32_t value;
};

struct Category {
  std::string_view name;
  std::vector<std::string_view> features;
};

constexpr std::int64_t kWord = 0xFFFFFFFF, kLong = 0x7FFFFFFFFFFFFFFF;

class Xml {
 public:
  Xml() {
    text_ =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<RegisterDescription ModelName=\"SimulatedStudioCamera\" VendorName=\"Rotunda\" ToolTip=\"Simulated camera\" "
        "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
        "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" "
        "ProductGuid=\"0d627654-1c5c-4bb7-a5a1-3c0a0e4a7a10\" VersionGuid=\"5f0ae0f2-45e5-4f3e-9b8e-6a3f6a3d2f11\" "
        "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n";
  }

  void category(const Category& group) {
    text_ += fmt::format("<Category Name=\"{}\">", group.name);
    for (const auto feature : group.features) text_ += fmt::format("<pFeature>{}</pFeature>", feature);
    text_ += "</Category>\n";
  }

  void text(std::string_view name, std::uint32_t address, int bytes, std::string_view access = "RO") {
    text_ += fmt::format(
        "<StringReg Name=\"{}\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
        "<pPort>Device</pPort></StringReg>\n",
        name, address, bytes, access);
  }

  void integer(const IntegerFeature& f) {
    text_ += fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue><Min>{1}</Min><Max>{2}</Max></Integer>\n",
                         f.name, f.min, f.max);
    number_register(f.name, f.address, f.access, f.bytes, f.sign);
  }

  // Some bits of a word; GenICam counts bits of a big-endian word from its most significant one.
  void bits(std::string_view name, std::uint32_t address, int first, int last) {
    text_ += fmt::format(
        "<MaskedIntReg Name=\"{}Reg\"><Address>0x{:x}</Address><Length>4</Length><AccessMode>RW</AccessMode>"
        "<pPort>Device</pPort><Cachable>NoCache</Cachable><LSB>{}</LSB><MSB>{}</MSB><Sign>Unsigned</Sign>"
        "<Endianess>BigEndian</Endianess></MaskedIntReg>\n",
        name, address, last, first);
  }

  void masked_integer(std::string_view name, std::uint32_t address, int first, int last, std::int64_t min,
                      std::int64_t max) {
    bits(name, address, first, last);
    text_ +=
        fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue><Min>{1}</Min><Max>{2}</Max><Inc>4</Inc></Integer>\n",
                    name, min, max);
  }

  void floating(const FloatFeature& f) {
    text_ += fmt::format(
        "<Float Name=\"{0}\"><pValue>{0}Scaled</pValue><Min>{1}</Min><Max>{2}</Max><Unit>{3}</Unit></Float>\n"
        "<Converter Name=\"{0}Scaled\"><FormulaTo>FROM * {4}</FormulaTo><FormulaFrom>TO / {4}</FormulaFrom>"
        "<pValue>{0}Reg</pValue><Slope>Increasing</Slope></Converter>\n",
        f.name, f.min, f.max, f.unit, f.scale);
    number_register(f.name, f.address, f.access, 4, "Unsigned");
  }

  void boolean(std::string_view name, std::uint32_t address) {
    text_ += fmt::format(
        "<Boolean Name=\"{0}\"><pValue>{0}Reg</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>\n", name);
    number_register(name, address, "RW", 4, "Unsigned");
  }

  void command(std::string_view name, std::uint32_t address, int value = 1) {
    text_ += fmt::format("<Command Name=\"{0}\"><pValue>{0}Reg</pValue><CommandValue>{1}</CommandValue></Command>\n",
                         name, value);
    number_register(name, address, "RW", 4, "Unsigned");
  }

  void enumeration(std::string_view name, std::uint32_t address, std::string_view access,
                   const std::vector<Entry>& entries) {
    text_ += fmt::format("<Enumeration Name=\"{}\">", name);
    for (const auto& entry : entries)
      text_ += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry.name, entry.value);
    text_ += fmt::format("<pValue>{}Reg</pValue></Enumeration>\n", name);
    number_register(name, address, access, 4, "Unsigned");
  }

  void raw(std::string_view more) { text_ += more; }

  std::string finished() && {
    text_ += "<Port Name=\"Device\"></Port>\n</RegisterDescription>\n";
    return std::move(text_);
  }

 private:
  void number_register(std::string_view name, std::uint32_t address, std::string_view access, int bytes,
                       std::string_view sign) {
    text_ += fmt::format(
        "<IntReg Name=\"{}Reg\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
        "<pPort>Device</pPort><Cachable>NoCache</Cachable><Sign>{}</Sign><Endianess>BigEndian</Endianess></IntReg>\n",
        name, address, bytes, access, sign);
  }

  std::string text_;
};

void list_categories(Xml& xml) {
  xml.category({"Root",
                {"DeviceControl", "ImageFormatControl", "AcquisitionControl", "AnalogControl", "ActionControl",
                 "PtpControl", "TransportLayerControl"}});
  xml.category({"DeviceControl",
                {"DeviceVendorName", "DeviceModelName", "DeviceVersion", "DeviceManufacturerInfo", "DeviceSerialNumber",
                 "DeviceUserID", "DeviceTemperature", "TimestampLatch", "TimestampLatchValue"}});
  xml.category({"ImageFormatControl",
                {"SensorWidth", "SensorHeight", "WidthMax", "HeightMax", "Width", "Height", "OffsetX", "OffsetY",
                 "PixelFormat"}});
  xml.category({"AcquisitionControl",
                {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameCount",
                 "AcquisitionFrameRate", "AcquisitionFrameRateEnable", "TriggerSelector", "TriggerMode",
                 "TriggerSource", "TriggerActivation", "TriggerSoftware", "ExposureMode", "ExposureTime"}});
  xml.category({"AnalogControl", {"Gain"}});
  xml.category({"ActionControl", {"ActionDeviceKey", "ActionSelector", "ActionGroupKey", "ActionGroupMask"}});
  xml.category({"PtpControl", {"PtpEnable", "PtpStatus", "PtpDataSetLatch", "PtpOffsetFromMaster"}});
  xml.category({"TransportLayerControl",
                {"PayloadSize", "GevSCPHostPort", "GevSCPSPacketSize", "GevSCPSFireTestPacket", "GevSCPSDoNotFragment",
                 "GevSCPD", "GevSCDA", "GevHeartbeatTimeout", "GevCurrentIPAddress", "GevTimestampControlLatch",
                 "GevTimestampValue", "GevTimestampTickFrequency"}});
}

void describe_device(Xml& xml) {
  xml.text("DeviceVendorName", 0x48, 32);
  xml.text("DeviceModelName", 0x68, 32);
  xml.text("DeviceVersion", 0x88, 32);
  xml.text("DeviceManufacturerInfo", 0xA8, 48);
  xml.text("DeviceSerialNumber", 0xD8, 16);
  xml.text("DeviceUserID", reg::kUserName, 16, "RW");
  xml.floating({"DeviceTemperature", reg::kTemperature, "RO", "C", 1000.0, 0.0, 120.0});
  xml.command("TimestampLatch", reg::kTimestampLatch);
  xml.integer({"TimestampLatchValue", reg::kTimestampHigh, "RO", 0, kLong, 8});
}

void describe_image(Xml& xml, const GigeCameraOptions& options) {
  for (const auto name : {"SensorWidth", "WidthMax", "Width"})
    xml.integer({name, reg::kWidth, "RO", options.width, options.width});
  for (const auto name : {"SensorHeight", "HeightMax", "Height"})
    xml.integer({name, reg::kHeight, "RO", options.height, options.height});
  xml.integer({"OffsetX", reg::kOffsetX, "RO", 0, 0});
  xml.integer({"OffsetY", reg::kOffsetY, "RO", 0, 0});
  std::vector<Entry> formats;
  for (const auto format : selectable_formats(options.format))
    formats.push_back({capture::to_string(format), pixel_code(format)});
  xml.enumeration("PixelFormat", reg::kPixelFormat, "RW", formats);
}

void describe_acquisition(Xml& xml) {
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
}

void describe_trigger(Xml& xml) {
  xml.enumeration("TriggerSelector", reg::kTriggerSelector, "RW", {{"FrameStart", 0}});
  xml.enumeration("TriggerMode", reg::kTriggerMode, "RW", {{"Off", 0}, {"On", 1}});
  xml.enumeration("TriggerSource", reg::kTriggerSource, "RW", {{"Software", 0}, {"Line0", 1}, {"Action1", 2}});
  xml.enumeration("TriggerActivation", reg::kTriggerActivation, "RW", {{"RisingEdge", 0}});
  xml.command("TriggerSoftware", reg::kTriggerSoftware);
  xml.integer({"ActionSelector", reg::kActionSelector, "RW", 0, 0});
  xml.integer({"ActionDeviceKey", reg::kActionDeviceKey, "RW", 0, kWord});
  xml.integer({"ActionGroupKey", reg::kActionGroupKey, "RW", 0, kWord});
  xml.integer({"ActionGroupMask", reg::kActionGroupMask, "RW", 0, kWord});
}

void describe_clock(Xml& xml) {
  xml.boolean("PtpEnable", reg::kPtpEnable);
  xml.enumeration("PtpStatus", reg::kPtpStatus, "RO", {{"Disabled", 3}, {"Master", 6}, {"Slave", 9}});
  xml.command("PtpDataSetLatch", reg::kPtpDataSetLatch);
  xml.integer({"PtpOffsetFromMaster", reg::kPtpOffset, "RO", -kLong, kLong, 8, "Signed"});
  xml.command("GevTimestampControlLatch", reg::kTimestampControl, 2);
  xml.integer({"GevTimestampValue", reg::kTimestampHigh, "RO", 0, kLong, 8});
  xml.integer({"GevTimestampTickFrequency", 0x93C, "RO", 0, kLong, 8});
}

void describe_transport(Xml& xml) {
  xml.integer({"PayloadSize", reg::kPayloadSize, "RO", 0, kWord});
  xml.integer({"GevSCPHostPort", reg::kHostPort, "RW", 0, 65535});
  xml.masked_integer("GevSCPSPacketSize", reg::kPacketSize, 16, 31, kMinPacketSize, kMaxPacketSize);
  xml.bits("GevSCPSFireTestPacket", reg::kPacketSize, 0, 0);
  xml.raw(
      "<Command Name=\"GevSCPSFireTestPacket\"><pValue>GevSCPSFireTestPacketReg</pValue>"
      "<CommandValue>1</CommandValue></Command>\n");
  xml.bits("GevSCPSDoNotFragment", reg::kPacketSize, 1, 1);
  xml.raw("<Boolean Name=\"GevSCPSDoNotFragment\"><pValue>GevSCPSDoNotFragmentReg</pValue></Boolean>\n");
  xml.integer({"GevSCPD", reg::kPacketDelay, "RW", 0, kWord});
  xml.integer({"GevSCDA", reg::kDestination, "RW", 0, kWord});
  xml.integer({"GevHeartbeatTimeout", reg::kHeartbeatMs, "RW", 500, 60000});
  xml.integer({"GevCurrentIPAddress", reg::kAddress, "RO", 0, kWord});
  xml.raw(
      "<Integer "
      "Name=\"TLParamsLocked\"><Visibility>Invisible</Visibility><Value>0</Value><Min>0</Min><Max>1</Max></Integer>\n");
}

}  // namespace

std::string genicam_xml(const GigeCameraOptions& options) {
  Xml xml;
  list_categories(xml);
  describe_device(xml);
  describe_image(xml, options);
  describe_acquisition(xml);
  describe_trigger(xml);
  describe_clock(xml);
  describe_transport(xml);
  return std::move(xml).finished();
}

}  // namespace rotunda::simulator
