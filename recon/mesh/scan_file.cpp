#include "recon/mesh/scan_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string_view>

#include "recon/gltf/gltf_character.h"
#include "recon/mesh/scan_polygons.h"
#include "recon/mesh/textured_mesh.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr std::uintmax_t kLargestScan = std::uintmax_t{4} << 30;

void append(const GltfCharacter& character, const CharacterState& state, const CharacterPart& part,
            TexturedMesh& textured) {
  const auto first = static_cast<std::uint32_t>(textured.mesh.positions.size());
  const auto positions = posed_positions(character, part, state);
  textured.mesh.positions.insert(textured.mesh.positions.end(), positions.begin(), positions.end());
  for (std::size_t v = 0; v < positions.size(); ++v)
    textured.shades.push_back(part.colours.empty() ? Vector3f::Ones() : Vector3f(part.colours[v].head<3>()));
  // A node that mirrors turns its triangles round.
  const bool is_mirrored = part.skin < 0 && state.file_from_node[part.node].topLeftCorner<3, 3>().determinant() < 0.0;
  for (auto t : part.triangles) {
    if (is_mirrored) std::swap(t[1], t[2]);
    auto& uv = textured.uv.emplace_back();
    uv.fill(Vector2f::Zero());
    for (std::size_t k = 0; k < 3 && !part.uv.empty(); ++k) uv[k] = part.uv[t[k]];
    textured.mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    textured.material.push_back(part.material);
  }
}

ScanFile read_gltf_scan(const fs::path& file) {
  auto character = read_gltf_character(file);
  const auto state = state_at(character, nullptr, 0.0);
  TexturedMesh textured;
  textured.shades_tint = true;
  bool is_coloured = false;
  for (const auto& part : character.parts) {
    append(character, state, part, textured);
    const auto* material = part.material < 0 ? nullptr : &character.materials[static_cast<std::size_t>(part.material)];
    is_coloured = is_coloured || !part.colours.empty() ||
                  (material != nullptr && (material->picture >= 0 || material->factor != Vector3f::Ones()));
  }
  textured.materials = std::move(character.materials);
  textured.pictures = std::move(character.pictures);
  if (is_coloured) paint_vertices(textured);
  return {std::move(textured.mesh), std::move(character.notes)};
}

bool is_gltf(const fs::path& file, const std::string& extension) {
  if (extension == ".glb" || extension == ".gltf") return true;
  std::array<char, 4> magic{};
  open_to_read(file).read(magic.data(), magic.size());
  return std::string_view(magic.data(), magic.size()) == "glTF";
}

}  // namespace

ScanFile read_scan(const fs::path& file) {
  if (!fs::exists(file)) throw InvalidInput(file.string() + ": there is no such file");
  if (fs::file_size(file) > kLargestScan)
    throw InvalidInput(fmt::format("{}: {} bytes; at most 4 GiB is read", file.string(), fs::file_size(file)));
  const auto extension = lower_extension(file);
  if (is_gltf(file, extension)) return read_gltf_scan(file);
  return extension == ".obj" ? read_obj_scan(file) : read_ply_scan(file);
}

}  // namespace rotunda::recon
