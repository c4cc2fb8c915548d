#pragma once
// What reading PLY and OBJ with OpenMesh needs. Private to recon/mesh.
#include <fmt/format.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/IO/importer/ImporterT.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <vector>

#include "config/errors.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

using Polygons = OpenMesh::PolyMesh_ArrayKernelT<>;

// Takes vertices as OpenMesh does but keeps every face, cut into a fan, manifold or not; knows when the header promised
// too much.
class PolygonCollector : public OpenMesh::IO::ImporterT<Polygons> {
 public:
  PolygonCollector(Polygons& vertices, TriangleMesh& mesh, const std::filesystem::path& file)
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

 protected:
  Polygons& vertices_;
  TriangleMesh& mesh_;

 private:
  std::filesystem::path file_;
  std::uintmax_t bytes_;
  std::size_t promised_vertices_ = 0, promised_faces_ = 0, faces_ = 0;
};

// OpenMesh has one reader and one writer a format, and they keep what they are at.
std::mutex& openmesh_mutex();

std::string lower_extension(const std::filesystem::path& file);  // ".ply", whatever its case

// Throws InvalidInput if there is no such file, std::system_error if it cannot be opened.
std::ifstream open_to_read(const std::filesystem::path& file);

// Throws CorruptData if what the stream holds is not all there.
void read_ply_polygons(const std::filesystem::path& file, std::ifstream& stream, PolygonCollector& collector,
                       OpenMesh::IO::Options& options);

// OpenMesh leaves out a vertex that it cannot read, and all faces then name others than they mean: throws CorruptData.
void check_obj_vertices(const std::filesystem::path& file, std::ifstream& stream);

void copy_vertices(const Polygons& from, const OpenMesh::IO::Options& found, TriangleMesh& mesh);

}  // namespace rotunda::recon
