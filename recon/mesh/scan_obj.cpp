#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "recon/mesh/picture_file.h"
#include "recon/mesh/scan_polygons.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2f;
using OpenMesh::IO::Options;

// What OpenMesh does not tell of an OBJ: libraries that are not there, each polygon's material, and polygons that name
// a vertex twice. Of those it takes each vertex once; with less than three it leaves them out.
class ObjOutline {
 public:
  ObjOutline(const fs::path& file, std::ifstream& stream) : file_(file) {
    for (std::string line; std::getline(stream, line);) {
      if (line.starts_with("v ")) ++vertices_;
      if (line.starts_with("vt ")) take_coordinates(line.c_str() + 3);
      if (line.starts_with("f ")) take_polygon(line.c_str() + 2);
      if (line.starts_with("usemtl "))
        material_ = names_.try_emplace(trimmed(line.substr(7)), names_.size() + 1).first->second;
      if (line.starts_with("mtllib ")) take_library(trimmed(line.substr(7)));
    }
  }
  std::vector<std::string> notes;
  std::vector<TexturedCollector::LeftOut> left_out;
  std::vector<std::pair<std::size_t, std::vector<Vector2f>>> reduced;  // polygons, counted without those left out
  std::vector<std::size_t> materials;                                  // of each polygon that is not left out; 0: none
  bool has_library = false;

 private:
  void take_coordinates(const char* at) {
    char* end = nullptr;
    const float u = std::strtof(at, &end), v = std::strtof(end, nullptr);
    uv_.emplace_back(u, v);
  }

  // The number at `at`, which is moved behind it, counted from 0; -1 if there is none.
  static long index(const char*& at, std::size_t count) {
    char* end = nullptr;
    const long number = std::strtol(at, &end, 10);
    at = end;
    return number < 0 ? std::max(-1L, static_cast<long>(count) + number) : number - 1;
  }

  void take_polygon(const char* at) {
    TexturedCollector::LeftOut polygon{.before = materials.size(), .material = material_};
    for (at += std::strspn(at, " \t\r"); *at != '\0'; at += std::strspn(at, " \t\r")) {
      const auto* token = at;
      polygon.corners.emplace_back(static_cast<int>(std::min(index(at, vertices_), 0x7FFFFFFFL)));
      if (*at == '/' && at[1] != '/') {
        const auto uv = index(++at, uv_.size());
        if (uv >= 0 && static_cast<std::size_t>(uv) < uv_.size())
          polygon.uv.push_back(uv_[static_cast<std::size_t>(uv)]);
      }
      at += std::strcspn(at, " \t\r");
      if (at == token) break;
    }
    if (polygon.corners.size() < 3) return;
    const auto [corners, uv] = without_repeats(polygon);
    if (corners < 3) return left_out.push_back(std::move(polygon));
    if (corners < polygon.corners.size()) reduced.emplace_back(materials.size(), uv);
    materials.push_back(material_);
  }

  // How many corners are left, with their coordinates.
  static std::pair<std::size_t, std::vector<Vector2f>> without_repeats(const TexturedCollector::LeftOut& polygon) {
    const auto& corners = polygon.corners;
    std::size_t count = 0;
    std::vector<Vector2f> uv;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto earlier = corners.begin() + static_cast<std::ptrdiff_t>(i);
      if (std::find(corners.begin(), earlier, corners[i]) != earlier) continue;
      ++count;
      if (polygon.uv.size() == corners.size()) uv.push_back(polygon.uv[i]);
    }
    return {count, uv};
  }

  // OpenMesh opens it by its name alone.
  void take_library(const std::string& name) {
    const auto library = file_.parent_path() / name;
    if (!is_file(library)) {
      if (fs::exists(library)) throw InvalidInput(fmt::format("{}: {} is no file", file_.string(), library.string()));
      return notes.push_back(fmt::format("its materials {} are missing", name));
    }
    if (fs::file_size(library) > kLargestInput)
      throw InvalidInput(fmt::format("{}: {} is larger than 1 GiB", file_.string(), library.string()));
    has_library = true;
  }

  fs::path file_;
  std::size_t vertices_ = 0, material_ = 0;
  std::vector<Vector2f> uv_;
  std::map<std::string, std::size_t> names_;
};

}  // namespace

ScanFile read_obj_scan(const fs::path& file) {
  auto stream = open_to_read(file);
  check_obj_vertices(file, stream);
  ObjOutline outline(file, stream);
  Polygons polygons;
  polygons.request_vertex_colors();
  TexturedMesh textured;
  TexturedCollector collector(polygons, textured, file);
  Options options(Options::VertexColor | Options::FaceColor | Options::FaceTexCoord);
  const bool is_read = [&] {
    omerr().disable();
    const std::lock_guard lock(openmesh_mutex());
    return OpenMesh::IO::IOManager().read(file.string(), collector, options);
  }();
  if (outline.materials.size() == collector.faces().size()) {
    for (const auto& [face, uv] : outline.reduced) collector.set_uv(face, uv);
    collector.put_back(outline.left_out, outline.materials);
  }
  if (!is_read || textured.mesh.triangles.empty()) throw CorruptData(file, 0, "is no OBJ mesh");
  copy_vertices(polygons, options, textured.mesh);
  // Without a library OpenMesh would take materials of files that it read before.
  if (outline.has_library) paint_polygons(file, collector, collector.pictures(), textured, outline.notes);
  return {std::move(textured.mesh), std::move(outline.notes)};
}

}  // namespace rotunda::recon
