#include "simulator/gige/genicam_writer.h"

#include <fmt/format.h>

#include <utility>

namespace rotunda::simulator {

GenicamWriter::GenicamWriter() {
  text_ =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<RegisterDescription ModelName=\"SimulatedStudioCamera\" VendorName=\"Rotunda\" ToolTip=\"Simulated camera\" "
      "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
      "MajorVersion=\"1\" MinorVersion=\"1\" SubMinorVersion=\"0\" "
      "ProductGuid=\"0d627654-1c5c-4bb7-a5a1-3c0a0e4a7a10\" VersionGuid=\"d3f7a5a2-6a0c-4a7e-9f8c-0b8f9d7d5a63\" "
      "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n";
}

void GenicamWriter::category(const Category& group) {
  text_ += fmt::format("<Category Name=\"{}\">", group.name);
  for (const auto feature : group.features) text_ += fmt::format("<pFeature>{}</pFeature>", feature);
  text_ += "</Category>\n";
}

void GenicamWriter::text(std::string_view name, std::uint32_t address, int bytes, std::string_view access) {
  text_ += fmt::format(
      "<StringReg Name=\"{}\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
      "<pPort>Device</pPort></StringReg>\n",
      name, address, bytes, access);
}

void GenicamWriter::integer(const IntegerFeature& f) {
  text_ += fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue><Min>{1}</Min>", f.name, f.min);
  text_ += f.max_node.empty() ? fmt::format("<Max>{}</Max>", f.max) : fmt::format("<pMax>{}</pMax>", f.max_node);
  text_ += fmt::format("<Inc>{}</Inc>", f.step);
  if (!f.unit.empty()) text_ += fmt::format("<Unit>{}</Unit>", f.unit);
  text_ += "</Integer>\n";
  number_register(f.name, f.address, f.access, f.bytes, f.sign);
}

void GenicamWriter::floating(const FloatFeature& f) {
  text_ +=
      fmt::format("<Float Name=\"{0}\"><pValue>{0}Scaled</pValue><Min>{1}</Min><Max>{2}</Max>", f.name, f.min, f.max);
  if (!f.unit.empty()) text_ += fmt::format("<Unit>{}</Unit>", f.unit);
  text_ += fmt::format(
      "</Float>\n<Converter Name=\"{0}Scaled\"><FormulaTo>FROM * {1}</FormulaTo><FormulaFrom>TO / {1}</FormulaFrom>"
      "<pValue>{0}Reg</pValue><Slope>Increasing</Slope></Converter>\n",
      f.name, f.scale);
  number_register(f.name, f.address, f.access, 4, "Unsigned", f.selector);
}

void GenicamWriter::boolean(std::string_view name, std::uint32_t address, std::string_view selector) {
  text_ += fmt::format(
      "<Boolean Name=\"{0}\"><pValue>{0}Reg</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>\n", name);
  number_register(name, address, "RW", 4, "Unsigned", selector);
}

void GenicamWriter::command(std::string_view name, std::uint32_t address, int value) {
  text_ += fmt::format("<Command Name=\"{0}\"><pValue>{0}Reg</pValue><CommandValue>{1}</CommandValue></Command>\n",
                       name, value);
  number_register(name, address, "RW", 4, "Unsigned");
}

void GenicamWriter::enum_entries(std::string_view name, const std::vector<Entry>& entries) {
  text_ += fmt::format("<Enumeration Name=\"{}\">", name);
  for (const auto& entry : entries)
    text_ += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry.name, entry.value);
  text_ += fmt::format("<pValue>{}Reg</pValue>", name);
}

void GenicamWriter::enumeration(std::string_view name, std::uint32_t address, std::string_view access,
                                const std::vector<Entry>& entries) {
  enum_entries(name, entries);
  text_ += "</Enumeration>\n";
  number_register(name, address, access, 4, "Unsigned");
}

void GenicamWriter::selector(std::string_view name, std::uint32_t address, const std::vector<Entry>& entries,
                             const std::vector<std::string_view>& features) {
  enum_entries(name, entries);
  for (const auto feature : features) text_ += fmt::format("<pSelected>{}</pSelected>", feature);
  text_ += "</Enumeration>\n";
  number_register(name, address, "RW", 4, "Unsigned");
}

void GenicamWriter::bits(std::string_view name, std::uint32_t address, int first, int last) {
  text_ += fmt::format(
      "<MaskedIntReg Name=\"{}Reg\"><Address>0x{:x}</Address><Length>4</Length><AccessMode>RW</AccessMode>"
      "<pPort>Device</pPort><Cachable>NoCache</Cachable><LSB>{}</LSB><MSB>{}</MSB><Sign>Unsigned</Sign>"
      "<Endianess>BigEndian</Endianess></MaskedIntReg>\n",
      name, address, last, first);
}

void GenicamWriter::masked_integer(std::string_view name, std::uint32_t address, int first, int last, std::int64_t min,
                                   std::int64_t max) {
  bits(name, address, first, last);
  text_ +=
      fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue><Min>{1}</Min><Max>{2}</Max><Inc>4</Inc></Integer>\n",
                  name, min, max);
}

void GenicamWriter::number_register(std::string_view name, std::uint32_t address, std::string_view access, int bytes,
                                    std::string_view sign, std::string_view selector) {
  text_ += fmt::format("<IntReg Name=\"{}Reg\"><Address>0x{:x}</Address>", name, address);
  if (!selector.empty()) text_ += fmt::format("<pIndex Offset=\"4\">{}</pIndex>", selector);
  text_ += fmt::format(
      "<Length>{}</Length><AccessMode>{}</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>"
      "<Sign>{}</Sign><Endianess>BigEndian</Endianess></IntReg>\n",
      bytes, access, sign);
}

std::string GenicamWriter::finished() && {
  text_ += "<Port Name=\"Device\"></Port>\n</RegisterDescription>\n";
  return std::move(text_);
}

}  // namespace rotunda::simulator
