#pragma once
// PLY and OBJ with what colours them, by OpenMesh. Private to scan_file.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recon/mesh/polygon_reader.h"
#include "recon/mesh/scan_file.h"
#include "recon/mesh/textured_mesh.h"

namespace rotunda::recon {

// Keeps what each polygon is coloured by, too.
class TexturedCollector : public PolygonCollector {
 public:
  struct Face {
    std::size_t first = 0;  // of its triangles
    int texture = -1;
    std::optional<Colour> colour;
  };
  TexturedCollector(Polygons& polygons, TexturedMesh& textured, const std::filesystem::path& file)
      : PolygonCollector(polygons, textured.mesh, file), textured_(textured) {}

  using PolygonCollector::add_face;
  using PolygonCollector::set_color;
  OpenMesh::FaceHandle add_face(const VHandles& corners) override;
  void add_face_texcoords(OpenMesh::FaceHandle face, OpenMesh::VertexHandle,
                          const std::vector<OpenMesh::Vec2f>& at) override;
  void set_face_texindex(OpenMesh::FaceHandle face, int texture) override { of(face).texture = texture; }
  void set_color(OpenMesh::FaceHandle face, const OpenMesh::Vec3uc& c) override {
    of(face).colour = {c[0], c[1], c[2]};
  }
  void add_texture_information(int id, std::string name) override { pictures_[id] = std::move(name); }

  // Coordinates of a polygon's corners, from the picture's lower left corner upwards; passed over if not one a corner.
  void set_uv(std::size_t face, const std::vector<Eigen::Vector2f>& uv);
  std::vector<Face>& faces() { return faces_; }
  std::size_t end_of(std::size_t face) const {  // of its triangles
    return face + 1 < faces_.size() ? faces_[face + 1].first : mesh_.triangles.size();
  }

  // A polygon that OpenMesh left out; `before`: how many of those that it read come first.
  struct LeftOut {
    std::size_t before = 0, material = 0;
    VHandles corners;
    std::vector<Eigen::Vector2f> uv;
  };
  // Puts them back, so that triangles have the file's numbers; `materials`: of each polygon that was read.
  void put_back(const std::vector<LeftOut>& left_out, const std::vector<std::size_t>& materials);
  const std::map<int, std::string>& pictures() const { return pictures_; }
  bool has_uv(std::size_t triangle) const { return has_uv_[triangle]; }

 private:
  Face& of(OpenMesh::FaceHandle face) { return faces_[static_cast<std::size_t>(face.idx())]; }

  TexturedMesh& textured_;
  std::vector<Face> faces_;
  std::vector<bool> has_uv_;
  std::map<int, std::string> pictures_;
};

// Pictures and colours of the polygons to the vertices; what is missing becomes a note. `names`: of pictures, by the
// numbers that faces have for them.
void paint_polygons(const std::filesystem::path& file, TexturedCollector& collector,
                    const std::map<int, std::string>& names, TexturedMesh& textured, std::vector<std::string>& notes);

std::string trimmed(const std::string& text);
bool is_file(const std::filesystem::path& file);

ScanFile read_obj_scan(const std::filesystem::path& file);
ScanFile read_ply_scan(const std::filesystem::path& file);

}  // namespace rotunda::recon
