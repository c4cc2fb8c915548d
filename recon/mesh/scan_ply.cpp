#include <new>
#include <sstream>
#include <string_view>

#include "recon/mesh/mesh_file.h"
#include "recon/mesh/scan_polygons.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2f;
using OpenMesh::IO::Options;

// What the header of a PLY says of pictures.
struct PlyPictures {
  std::map<int, std::string> names;
  bool at_corners = false;  // coordinates
  bool at_vertices = false;
  bool has_long_lists = false;
};

PlyPictures pictures_of_ply(const fs::path& file) {
  constexpr std::streamoff kLongestHeader = 1 << 20;
  PlyPictures found;
  bool has_element = false;
  auto stream = open_to_read(file);
  for (std::string line; std::getline(stream, line) && stream.tellg() < kLongestHeader;) {
    line = trimmed(line);
    if (line == "end_header") break;
    has_element = has_element || line.starts_with("element ");
    if (!has_element && line.starts_with("property "))
      throw CorruptData(file, 0, "is no PLY mesh: its header has a property of nothing");
    constexpr std::string_view kNames = "comment TextureFile ";
    if (line.starts_with(kNames))
      found.names.emplace(static_cast<int>(found.names.size()), trimmed(line.substr(kNames.size())));
    std::istringstream words(line);
    std::string property, list, count, type, name;
    words >> property >> list >> count >> type >> name;
    if (property != "property") continue;
    // Lists counted by a byte alone: OpenMesh makes room for whatever the count says.
    if (list == "list" && name == "texcoord") found.at_corners = true;
    if (list == "list" && !name.starts_with("vertex_ind") && count != "uchar" && count != "uint8")
      found.has_long_lists = true;
    if (count == "s" || count == "u" || count == "texture_u") found.at_vertices = true;
  }
  return found;
}

// As text a list may claim any length: walks through all elements, which must be those of the header.
void check_text_lists(const fs::path& file) {
  auto stream = open_to_read(file);
  std::vector<std::pair<std::uint64_t, std::vector<bool>>> elements;  // how many; of each property: is it a list
  for (std::string line; std::getline(stream, line) && trimmed(line) != "end_header";) {
    std::istringstream words(line);
    std::string keyword, second;
    std::uint64_t count = 0;
    words >> keyword >> second >> count;
    if (keyword == "format" && second != "ascii") return;
    if (keyword == "element") elements.emplace_back(count, std::vector<bool>());
    if (keyword == "property" && !elements.empty()) elements.back().second.push_back(second == "list");
  }
  std::string word;
  for (const auto& [count, lists] : elements)
    for (std::uint64_t i = 0; i < count && stream; ++i)
      for (const bool is_list : lists) {
        if (!(stream >> word) || !is_list) continue;
        const bool is_count = word.size() <= 3 && word.find_first_not_of("0123456789") == std::string::npos;
        if (!is_count)
          throw CorruptData(file, 0, fmt::format("is no PLY mesh: a list of {} numbers", word.substr(0, 20)));
        for (int n = std::stoi(word); n > 0 && stream >> word;) --n;
      }
}

template <class Number>
void take_corners(const Polygons& polygons, TexturedCollector& collector) {
  OpenMesh::FPropHandleT<std::vector<Number>> property;
  if (!polygons.get_property_handle(property, "texcoord")) return;
  for (std::size_t f = 0; f < collector.faces().size(); ++f) {
    const auto& numbers = polygons.property(property, OpenMesh::FaceHandle(static_cast<int>(f)));
    std::vector<Vector2f> uv;
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2)
      uv.emplace_back(static_cast<float>(numbers[i]), static_cast<float>(numbers[i + 1]));
    collector.set_uv(f, uv);
  }
}

// Coordinates at the vertices, under the names programs give them.
std::vector<Vector2f> vertex_coordinates(const Polygons& polygons, const Options& found) {
  std::vector<Vector2f> uv;
  OpenMesh::VPropHandleT<float> u, v;
  const bool is_named = polygons.get_property_handle(u, "texture_u") && polygons.get_property_handle(v, "texture_v");
  if (!is_named && !found.vertex_has_texcoord()) return uv;
  for (const auto vertex : polygons.vertices()) {
    if (is_named)
      uv.emplace_back(polygons.property(u, vertex), polygons.property(v, vertex));
    else
      uv.emplace_back(polygons.texcoord2D(vertex)[0], polygons.texcoord2D(vertex)[1]);
  }
  return uv;
}

void take_vertices(const std::vector<Vector2f>& uv, const TexturedMesh& textured, TexturedCollector& collector) {
  if (uv.empty()) return;
  const auto& triangles = textured.mesh.triangles;
  const auto& faces = collector.faces();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto end = collector.end_of(f);
    if (faces[f].first == end || collector.has_uv(faces[f].first)) continue;
    std::vector<Vector2f> corners = {uv[triangles[faces[f].first][0]], uv[triangles[faces[f].first][1]]};
    for (auto t = faces[f].first; t < end; ++t) corners.push_back(uv[triangles[t][2]]);
    collector.set_uv(f, corners);
  }
}

void take_texture_numbers(const Polygons& polygons, TexturedCollector& collector) {
  OpenMesh::FPropHandleT<int> property;
  const bool is_there = polygons.get_property_handle(property, "texnumber");
  for (std::size_t f = 0; f < collector.faces().size(); ++f)
    collector.faces()[f].texture =
        is_there ? polygons.property(property, OpenMesh::FaceHandle(static_cast<int>(f))) : 0;
}

}  // namespace

ScanFile read_ply_scan(const fs::path& file) {
  ScanFile scan;
  const auto pictures = pictures_of_ply(file);
  if (pictures.names.empty() || pictures.has_long_lists || (!pictures.at_corners && !pictures.at_vertices)) {
    scan.mesh = read_ply(file);
    if (!pictures.names.empty())
      scan.notes.emplace_back(
          "its picture is left out: nothing says where it lies, or lists that are not counted by bytes");
    return scan;
  }
  check_text_lists(file);
  auto stream = open_to_read(file);
  Polygons polygons;
  polygons.request_vertex_normals();
  polygons.request_vertex_colors();
  polygons.request_vertex_texcoords2D();
  TexturedMesh textured;
  TexturedCollector collector(polygons, textured, file);
  Options options(Options::VertexNormal | Options::VertexColor | Options::VertexTexCoord | Options::Custom);
  try {
    read_ply_polygons(file, stream, collector, options);
  } catch (const std::bad_alloc&) {  // a list of another name with an absurd count
    throw CorruptData(file, 0, "is no PLY mesh: a list in it is longer than any memory");
  }
  copy_vertices(polygons, options, textured.mesh);
  take_corners<float>(polygons, collector);
  take_corners<double>(polygons, collector);
  take_vertices(vertex_coordinates(polygons, options), textured, collector);
  take_texture_numbers(polygons, collector);
  paint_polygons(file, collector, pictures.names, textured, scan.notes);
  scan.mesh = std::move(textured.mesh);
  return scan;
}

}  // namespace rotunda::recon
