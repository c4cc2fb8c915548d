#include "recon/export/glb_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <system_error>

#include "config/errors.h"
#include "recon/export/clip_surface.h"

namespace rotunda::recon {
namespace {

constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123,
              kUnsignedByte = 5121;  // glTF's names are OpenGL's

std::string word(std::size_t value) {  // little-endian
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>((value >> shift) & 0xff));
  return bytes;
}

// 8-bit sRGB to linear light, 16 bits (IEC 61966-2-1).
std::uint16_t linear_light(std::uint8_t value) {
  const double s = value / 255.0;
  const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(65535.0 * linear));
}

}  // namespace

GlbFile::GlbFile()
    : json{{"asset", {{"version", "2.0"}, {"generator", "Rotunda"}}},
           {"accessors", nlohmann::json::array()},
           {"bufferViews", nlohmann::json::array()}} {}

std::size_t GlbFile::add_view(const void* bytes, std::size_t size, Target target) {
  binary_.resize((binary_.size() + 3) / 4 * 4);
  nlohmann::json view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}};
  if (target != kNone) view["target"] = static_cast<int>(target);
  json["bufferViews"].push_back(std::move(view));
  binary_.append(static_cast<const char*>(bytes), size);
  return json["bufferViews"].size() - 1;
}

std::size_t GlbFile::add_accessor(std::size_t view, int component_type, const char* type, std::size_t count) {
  json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", component_type}, {"type", type}, {"count", count}});
  return json["accessors"].size() - 1;
}

std::size_t GlbFile::add_positions(const std::vector<Eigen::Vector3f>& positions) {
  const auto view = add_view(positions.data(), positions.size() * sizeof(positions[0]), kVertices);
  const auto accessor = add_accessor(view, kFloat, "VEC3", positions.size());
  Eigen::Vector3f low = positions.front(), high = low;
  for (const auto& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  json["accessors"][accessor]["min"] = {low.x(), low.y(), low.z()};
  json["accessors"][accessor]["max"] = {high.x(), high.y(), high.z()};
  return accessor;
}

std::size_t GlbFile::add_normals(const std::vector<Eigen::Vector3f>& normals) {
  const auto view = add_view(normals.data(), normals.size() * sizeof(normals[0]), kVertices);
  return add_accessor(view, kFloat, "VEC3", normals.size());
}

std::size_t GlbFile::add_values(const std::vector<Eigen::Vector3f>& values) {
  const auto view = add_view(values.data(), values.size() * sizeof(values[0]), kNone);
  return add_accessor(view, kFloat, "VEC3", values.size());
}

std::size_t GlbFile::add_rotations(const std::vector<Eigen::Vector4f>& rotations) {
  const auto view = add_view(rotations.data(), rotations.size() * sizeof(rotations[0]), kNone);
  return add_accessor(view, kFloat, "VEC4", rotations.size());
}

std::size_t GlbFile::add_texture_coordinates(const std::vector<Eigen::Vector2f>& coordinates) {
  const auto view = add_view(coordinates.data(), coordinates.size() * sizeof(coordinates[0]), kVertices);
  return add_accessor(view, kFloat, "VEC2", coordinates.size());
}

std::size_t GlbFile::add_indices(const std::vector<std::uint32_t>& indices) {
  const auto view = add_view(indices.data(), indices.size() * sizeof(indices[0]), kIndices);
  return add_accessor(view, kUnsignedInt, "SCALAR", indices.size());
}

std::size_t GlbFile::add_scalars(const std::vector<float>& scalars) {
  const auto view = add_view(scalars.data(), scalars.size() * sizeof(scalars[0]), kNone);
  const auto accessor = add_accessor(view, kFloat, "SCALAR", scalars.size());
  const auto [low, high] = std::minmax_element(scalars.begin(), scalars.end());
  json["accessors"][accessor]["min"] = {*low};
  json["accessors"][accessor]["max"] = {*high};
  return accessor;
}

std::size_t GlbFile::add_colours(const std::vector<Colour>& colours) {
  std::vector<std::array<std::uint16_t, 4>> linear;
  for (const auto& colour : colours) {
    auto& texel = linear.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) texel[i] = linear_light(colour[i]);
    texel[3] = 65535;
  }
  const auto view = add_view(linear.data(), linear.size() * sizeof(linear[0]), kVertices);
  const auto accessor = add_accessor(view, kUnsignedShort, "VEC4", linear.size());
  json["accessors"][accessor]["normalized"] = true;
  return accessor;
}

std::size_t GlbFile::add_joints(const std::vector<std::array<std::uint8_t, 4>>& joints) {
  const auto view = add_view(joints.data(), joints.size() * sizeof(joints[0]), kVertices);
  return add_accessor(view, kUnsignedByte, "VEC4", joints.size());
}

std::size_t GlbFile::add_weights(const std::vector<Eigen::Vector4f>& weights) {
  const auto view = add_view(weights.data(), weights.size() * sizeof(weights[0]), kVertices);
  return add_accessor(view, kFloat, "VEC4", weights.size());
}

std::size_t GlbFile::add_matrices(const std::vector<Eigen::Matrix4f>& matrices) {
  const auto view = add_view(matrices.data(), matrices.size() * sizeof(matrices[0]), kNone);
  return add_accessor(view, kFloat, "MAT4", matrices.size());
}

std::size_t GlbFile::add_png(const std::vector<std::uint8_t>& png) {
  json["images"].push_back({{"bufferView", add_view(png.data(), png.size(), kNone)}, {"mimeType", "image/png"}});
  return json["images"].size() - 1;
}

std::size_t GlbFile::add_unlit_material(std::size_t image) {
  constexpr int kLinear = 9729, kLinearOfMipmaps = 9987, kClampToEdge = 33071;
  if (!json.contains("samplers"))
    json["samplers"].push_back(
        {{"magFilter", kLinear}, {"minFilter", kLinearOfMipmaps}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}});
  json["textures"].push_back({{"source", image}, {"sampler", 0}});
  json["extensionsUsed"] = {"KHR_materials_unlit"};
  json["materials"].push_back({{"pbrMetallicRoughness",
                                {{"baseColorTexture", {{"index", json["textures"].size() - 1}}},
                                 {"metallicFactor", 0.0},
                                 {"roughnessFactor", 1.0}}},
                               {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}});
  return json["materials"].size() - 1;
}

std::size_t GlbFile::add_plain_material() {
  json["extensionsUsed"] = {"KHR_materials_unlit"};
  json["materials"].push_back({{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
                               {"doubleSided", true},
                               {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}});
  return json["materials"].size() - 1;
}

void GlbFile::write(const std::filesystem::path& file) const {
  auto whole = json;
  const std::size_t padding = (4 - binary_.size() % 4) % 4;
  const std::size_t chunk = binary_.size() + padding;
  whole["buffers"] = {{{"byteLength", chunk}}};
  auto text = whole.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t length = 12 + 8 + text.size() + 8 + chunk;
  if (length > std::numeric_limits<std::uint32_t>::max())
    throw InvalidInput(file.string() + " would be larger than the 4 GB that a .glb can hold; export fewer frames, or " +
                       "a coarser level");
  write_whole(file, [&](const std::filesystem::path& part) {
    errno = 0;
    std::ofstream out(part, std::ios::binary);
    out << "glTF" << word(2) << word(length) << word(text.size()) << "JSON" << text;
    out << word(chunk) << std::string("BIN\0", 4) << binary_ << std::string(padding, '\0') << std::flush;
    if (!out) throw std::system_error(errno ? errno : EIO, std::generic_category(), "writing " + file.string());
  });
}

}  // namespace rotunda::recon
