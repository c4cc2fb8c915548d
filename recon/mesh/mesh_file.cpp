#include "recon/mesh/mesh_file.h"

#include <fmt/format.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/IO/importer/ImporterT.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <system_error>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using OpenMesh::IO::Options;
using Polygons = OpenMesh::PolyMesh_ArrayKernelT<>;

// Takes vertices as OpenMesh does but keeps every face, manifold or not; knows when the header promised too much.
class Collector : public OpenMesh::IO::ImporterT<Polygons> {
 public:
  Collector(Polygons& vertices, TriangleMesh& mesh, const std::filesystem::path& file)
      : ImporterT(vertices), vertices_(vertices), mesh_(mesh), file_(file), bytes_(std::filesystem::file_size(file)) {}

  void reserve(unsigned int vertices, unsigned int, unsigned int faces) override {
    if (static_cast<std::uintmax_t>(vertices) + faces > bytes_)  // each takes a byte at the very least
      throw CorruptData(file_, 0,
                        fmt::format("{} vertices and {} faces do not fit in {} bytes", vertices, faces, bytes_));
    promised_vertices_ = vertices;
    promised_faces_ = faces;
  }

  OpenMesh::FaceHandle add_face(const VHandles& corners) override {
    ++faces_;
    for (const auto corner : corners)
      if (corner.idx() < 0 || static_cast<std::size_t>(corner.idx()) >= vertices_.n_vertices())
        throw CorruptData(
            file_, 0, fmt::format("face {} names vertex {} of {}", faces_ - 1, corner.idx(), vertices_.n_vertices()));
    const auto index = [&](std::size_t i) { return static_cast<std::uint32_t>(corners[i].idx()); };
    for (std::size_t i = 2; i < corners.size(); ++i) mesh_.triangles.push_back({index(0), index(i - 1), index(i)});
    return OpenMesh::FaceHandle(static_cast<int>(faces_ - 1));  // an invalid one would be told on stderr
  }

  // The faces are not OpenMesh's, so it has nowhere to keep an OBJ's texture coordinates.
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle, const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle, const std::vector<OpenMesh::Vec3f>&) override {}

  bool is_complete() const { return vertices_.n_vertices() == promised_vertices_ && faces_ == promised_faces_; }

 private:
  Polygons& vertices_;
  TriangleMesh& mesh_;
  std::filesystem::path file_;
  std::uintmax_t bytes_;
  std::size_t promised_vertices_ = 0, promised_faces_ = 0, faces_ = 0;
};

// OpenMesh has one reader and one writer a format, and they keep what they are at.
std::mutex one_at_a_time;

[[noreturn]] void throw_errno(const std::filesystem::path& file, const char* what) {
  throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + ": " + what);
}

// OpenMesh's reader goes on past the end of a stream; this one throws there instead.
bool read_with_openmesh(std::ifstream& stream, Collector& collector, Options& options) {
  omerr().disable();  // the caller tells
  stream.exceptions(std::ios::failbit | std::ios::badbit);
  const std::lock_guard lock(one_at_a_time);
  try {
    return OpenMesh::IO::IOManager().read(stream, ".ply", collector, options);
  } catch (const std::ios_base::failure&) {
    return false;
  }
}

void copy_vertices(const Polygons& from, const Options& found, TriangleMesh& mesh) {
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

std::ifstream open_to_read(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) throw InvalidInput(file.string() + ": there is no such file");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_errno(file, "cannot be opened");
  return stream;
}

// OpenMesh leaves out a vertex that it cannot read, and all faces then name others than they mean.
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

TriangleMesh read_obj(const std::filesystem::path& file) {
  auto stream = open_to_read(file);
  check_obj_vertices(file, stream);
  Polygons vertices;
  TriangleMesh mesh;
  Collector collector(vertices, mesh, file);
  Options options;
  const bool is_read = [&] {
    const std::lock_guard lock(one_at_a_time);
    return OpenMesh::IO::IOManager().read(stream, ".obj", collector, options);
  }();
  if (!is_read || mesh.triangles.empty())
    throw CorruptData(file, 0, "is no OBJ mesh");
  copy_vertices(vertices, options, mesh);
  return mesh;
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file) {
  auto extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".obj" ? read_obj(file) : read_ply(file);
}

TriangleMesh read_ply(const std::filesystem::path& file) {
  auto stream = open_to_read(file);
  Polygons vertices;
  vertices.request_vertex_normals();
  vertices.request_vertex_colors();
  TriangleMesh mesh;
  Collector collector(vertices, mesh, file);
  Options options(Options::VertexNormal | Options::VertexColor);
  if (!read_with_openmesh(stream, collector, options) || !collector.is_complete())
    throw CorruptData(file, 0, "is no PLY mesh, ends early, or holds something that is no number");
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
    const std::lock_guard lock(one_at_a_time);
    if (!OpenMesh::IO::write_mesh(polygons, stream, ".ply", options)) throw_errno(file, "cannot be written");
  }
  stream.close();
  if (!stream) throw_errno(file, "cannot be written");
}

}  // namespace rotunda::recon
