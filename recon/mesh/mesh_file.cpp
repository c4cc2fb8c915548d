#include "recon/mesh/mesh_file.h"

#include <fmt/format.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <mutex>
#include <system_error>

#include "config/errors.h"
#include "recon/mesh/polygon_reader.h"

namespace rotunda::recon {
namespace {

using OpenMesh::IO::Options;

[[noreturn]] void throw_errno(const std::filesystem::path& file, const char* what) {
  throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + ": " + what);
}

void check(const TriangleMesh& mesh) {
  const auto fits = [&](std::size_t count) { return count == 0 || count == mesh.positions.size(); };
  if (!fits(mesh.normals.size()) || !fits(mesh.colours.size()))
    throw InvalidInput("a mesh to write needs one normal and one colour a position, or none");
}

Polygons to_polygons(const TriangleMesh& mesh) {
  Polygons polygons;
  polygons.request_vertex_normals();
  polygons.request_vertex_colors();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto& p = mesh.positions[i];
    const auto v = polygons.add_vertex({p.x(), p.y(), p.z()});
    if (!mesh.normals.empty()) polygons.set_normal(v, {mesh.normals[i].x(), mesh.normals[i].y(), mesh.normals[i].z()});
    if (!mesh.colours.empty()) polygons.set_color(v, {mesh.colours[i][0], mesh.colours[i][1], mesh.colours[i][2]});
  }
  const auto handle = [](std::uint32_t i) { return OpenMesh::VertexHandle(static_cast<int>(i)); };
  for (const auto& t : mesh.triangles)
    if (!polygons.add_face({handle(t[0]), handle(t[1]), handle(t[2])}).is_valid())
      throw InvalidInput("a mesh to write must be a manifold surface");
  return polygons;
}

TriangleMesh read_obj(const std::filesystem::path& file) {
  auto stream = open_to_read(file);
  check_obj_vertices(file, stream);
  Polygons vertices;
  TriangleMesh mesh;
  PolygonCollector collector(vertices, mesh, file);
  Options options;
  const bool is_read = [&] {
    const std::lock_guard lock(openmesh_mutex());
    return OpenMesh::IO::IOManager().read(stream, ".obj", collector, options);
  }();
  if (!is_read || mesh.triangles.empty()) throw CorruptData(file, 0, "is no OBJ mesh");
  copy_vertices(vertices, options, mesh);
  return mesh;
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file) {
  return lower_extension(file) == ".obj" ? read_obj(file) : read_ply(file);
}

TriangleMesh read_ply(const std::filesystem::path& file) {
  auto stream = open_to_read(file);
  Polygons vertices;
  vertices.request_vertex_normals();
  vertices.request_vertex_colors();
  TriangleMesh mesh;
  PolygonCollector collector(vertices, mesh, file);
  Options options(Options::VertexNormal | Options::VertexColor);
  read_ply_polygons(file, stream, collector, options);
  copy_vertices(vertices, options, mesh);
  return mesh;
}

void write_ply(const std::filesystem::path& file, const TriangleMesh& mesh) {
  check(mesh);
  const auto polygons = to_polygons(mesh);
  Options options(Options::Binary);
  if (!mesh.normals.empty()) options += Options::VertexNormal;
  if (!mesh.colours.empty()) options += Options::VertexColor;
  errno = 0;
  std::ofstream stream(file, std::ios::binary);
  if (!stream) throw_errno(file, "cannot be created");
  {
    const std::lock_guard lock(openmesh_mutex());
    if (!OpenMesh::IO::write_mesh(polygons, stream, ".ply", options)) throw_errno(file, "cannot be written");
  }
  stream.close();
  if (!stream) throw_errno(file, "cannot be written");
}

}  // namespace rotunda::recon
