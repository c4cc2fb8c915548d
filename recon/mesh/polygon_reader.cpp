#include "recon/mesh/polygon_reader.h"

#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>

namespace rotunda::recon {
namespace {

// OpenMesh's reader goes on past the end of a stream; this one throws there instead.
bool read_with_openmesh(std::ifstream& stream, PolygonCollector& collector, OpenMesh::IO::Options& options) {
  omerr().disable();  // the caller tells
  stream.exceptions(std::ios::failbit | std::ios::badbit);
  const std::lock_guard lock(openmesh_mutex());
  try {
    return OpenMesh::IO::IOManager().read(stream, ".ply", collector, options);
  } catch (const std::ios_base::failure&) {
    return false;
  }
}

}  // namespace

std::mutex& openmesh_mutex() {
  static std::mutex one_at_a_time;
  return one_at_a_time;
}

void read_ply_polygons(const std::filesystem::path& file, std::ifstream& stream, PolygonCollector& collector,
                       OpenMesh::IO::Options& options) {
  if (!read_with_openmesh(stream, collector, options) || !collector.is_complete())
    throw CorruptData(file, 0, "is no PLY mesh, ends early, or holds something that is no number");
}

void copy_vertices(const Polygons& from, const OpenMesh::IO::Options& found, TriangleMesh& mesh) {
  for (const auto v : from.vertices()) {
    const auto& p = from.point(v);
    mesh.positions.emplace_back(p[0], p[1], p[2]);
    if (found.vertex_has_normal()) {
      const auto& n = from.normal(v);
      mesh.normals.emplace_back(n[0], n[1], n[2]);
    }
    if (found.vertex_has_color()) mesh.colours.push_back({from.color(v)[0], from.color(v)[1], from.color(v)[2]});
  }
}

std::string lower_extension(const std::filesystem::path& file) {
  auto extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::ifstream open_to_read(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) throw InvalidInput(file.string() + ": there is no such file");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + ": cannot be opened");
  return stream;
}

void check_obj_vertices(const std::filesystem::path& file, std::ifstream& stream) {
  std::string line;
  for (std::uint64_t offset = 0; std::getline(stream, line); offset += line.size() + 1) {
    if (line.rfind("v ", 0) != 0) continue;
    const char* at = line.c_str() + 2;
    for (int i = 0; i < 3; ++i) {
      char* end = nullptr;
      if (!std::isfinite(std::strtof(at, &end)) || end == at)
        throw CorruptData(file, offset, fmt::format("a vertex has a coordinate that is no finite number: {}", line));
      at = end;
    }
  }
  stream.clear();
  stream.seekg(0);
}

}  // namespace rotunda::recon
