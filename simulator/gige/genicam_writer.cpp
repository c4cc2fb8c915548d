#include "simulator/gige/genicam_writer.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

namespace rotunda::simulator {
namespace {

// That GenApi takes for the maximum of an unsigned register.
std::int64_t largest(int bytes) {
  return bytes == 4 ? 0xFFFFFFFF : std::numeric_limits<std::int64_t>::max();
}

}  // namespace

GenicamWriter::GenicamWriter() {
  text_ =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<RegisterDescription ModelName=\"SimulatedStudioCamera\" VendorName=\"Rotunda\" ToolTip=\"Simulated camera\" "
      "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
      "MajorVersion=\"1\" MinorVersion=\"1\" SubMinorVersion=\"0\" "
      "ProductGuid=\"0d627654-1c5c-4bb7-a5a1-3c0a0e4a7a10\" VersionGuid=\"d3f7a5a2-6a0c-4a7e-9f8c-0b8f9d7d5a63\" "
      "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\"\n>";
}

void GenicamWriter::category(const Category& group) {
  text_ += fmt::format("<Category Name=\"{}\">", group.name);
  for (const auto feature : group.features) text_ += fmt::format("<pFeature>{}</pFeature>", feature);
  text_ += "</Category\n>";
}

void GenicamWriter::text(std::string_view name, std::uint32_t address, int bytes, std::string_view access) {
  text_ += fmt::format(
      "<StringReg Name=\"{}\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
      "<pPort>Device</pPort></StringReg\n>",
      name, address, bytes, access);
}

// What nobody may write needs no limits: the register itself is the feature.
void GenicamWriter::integer(const IntegerFeature& f) {
  const bool is_plain = f.access == "RO" && f.unit.empty() && !registers_.contains(f.address);
  const auto value = register_of({f.name, f.address, f.access, f.bytes, f.sign}, is_plain ? "" : "Reg");
  if (is_plain) return;
  text_ += fmt::format("<Integer Name=\"{}\"><pValue>{}</pValue>", f.name, value);
  if (f.min != 0 || f.max != largest(f.bytes)) {
    text_ += fmt::format("<Min>{}</Min>", f.min);
    text_ += f.max_node.empty() ? fmt::format("<Max>{}</Max>", f.max) : fmt::format("<pMax>{}</pMax>", f.max_node);
  }
  if (f.step != 1) text_ += fmt::format("<Inc>{}</Inc>", f.step);
  if (!f.unit.empty()) text_ += fmt::format("<Unit>{}</Unit>", f.unit);
  text_ += "</Integer\n>";
}

void GenicamWriter::floating(const FloatFeature& f) {
  const auto value = register_of({.name = f.name, .address = f.address, .access = f.access, .selector = f.selector});
  text_ +=
      fmt::format("<Float Name=\"{0}\"><pValue>{0}Scaled</pValue><Min>{1}</Min><Max>{2}</Max>", f.name, f.min, f.max);
  if (!f.unit.empty()) text_ += fmt::format("<Unit>{}</Unit>", f.unit);
  text_ += fmt::format(
      "</Float\n><Converter Name=\"{0}Scaled\"><FormulaTo>FROM * {1}</FormulaTo><FormulaFrom>TO / {1}</FormulaFrom>"
      "<pValue>{2}</pValue><Slope>Increasing</Slope></Converter\n>",
      f.name, f.scale, value);
}

void GenicamWriter::boolean(std::string_view name, std::uint32_t address, std::string_view selector) {
  const auto value = register_of({.name = name, .address = address, .selector = selector});
  text_ += fmt::format("<Boolean Name=\"{}\"><pValue>{}</pValue></Boolean\n>", name, value);
}

void GenicamWriter::command(std::string_view name, std::uint32_t address, int value) {
  const auto where = register_of({.name = name, .address = address});
  text_ += fmt::format("<Command Name=\"{}\"><pValue>{}</pValue><CommandValue>{}</CommandValue></Command\n>", name,
                       where, value);
}

void GenicamWriter::enumeration(std::string_view name, std::uint32_t address, std::string_view access,
                                const std::vector<Entry>& entries, const std::vector<std::string_view>& selected) {
  const auto value = register_of({.name = name, .address = address, .access = access});
  text_ += fmt::format("<Enumeration Name=\"{}\">", name);
  for (const auto& entry : entries)
    text_ += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry.name, entry.value);
  text_ += fmt::format("<pValue>{}</pValue>", value);
  for (const auto feature : selected) text_ += fmt::format("<pSelected>{}</pSelected>", feature);
  text_ += "</Enumeration\n>";
}

void GenicamWriter::selector(std::string_view name, std::uint32_t address, const std::vector<Entry>& entries,
                             const std::vector<std::string_view>& features) {
  enumeration(name, address, "RW", entries, features);
}

void GenicamWriter::bits(std::string_view name, std::uint32_t address, int first, int last) {
  text_ += fmt::format(
      "<MaskedIntReg Name=\"{}Reg\"><Address>0x{:x}</Address><Length>4</Length><AccessMode>RW</AccessMode>"
      "<pPort>Device</pPort><Cachable>NoCache</Cachable><LSB>{}</LSB><MSB>{}</MSB>"
      "<Endianess>BigEndian</Endianess></MaskedIntReg\n>",
      name, address, last, first);
}

void GenicamWriter::masked_integer(std::string_view name, std::uint32_t address, int first, int last, std::int64_t min,
                                   std::int64_t max) {
  bits(name, address, first, last);
  text_ +=
      fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue><Min>{1}</Min><Max>{2}</Max><Inc>4</Inc></Integer\n>",
                  name, min, max);
}

// What the schema takes for granted is left out: clients take some microseconds for each element.
std::string GenicamWriter::register_of(const Register& r, std::string_view suffix) {
  const auto [known, is_new] = registers_.try_emplace(r.address, fmt::format("{}{}", r.name, suffix));
  if (!is_new) return known->second;
  text_ += fmt::format("<IntReg Name=\"{}\"><Address>0x{:x}</Address>", known->second, r.address);
  if (!r.selector.empty()) text_ += fmt::format("<pIndex Offset=\"4\">{}</pIndex>", r.selector);
  text_ += fmt::format("<Length>{}</Length>", r.bytes);
  if (r.access != "RO") text_ += fmt::format("<AccessMode>{}</AccessMode>", r.access);
  text_ += "<pPort>Device</pPort><Cachable>NoCache</Cachable>";
  if (r.sign != "Unsigned") text_ += fmt::format("<Sign>{}</Sign>", r.sign);
  text_ += "<Endianess>BigEndian</Endianess></IntReg\n>";
  return known->second;
}

std::string GenicamWriter::finished() && {
  text_ += "<Port Name=\"Device\"></Port\n></RegisterDescription\n>";
  return std::move(text_);
}

}  // namespace rotunda::simulator
