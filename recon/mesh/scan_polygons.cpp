#include "recon/mesh/scan_polygons.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/srgb.h"
#include "recon/mesh/picture_file.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2f;
using Eigen::Vector3f;

Vector3f linear(const Colour& colour) {
  return capture::linear_of({colour[0], colour[1], colour[2]}).cast<float>();
}

// Where a picture lies: names are relative to the scan, may come from Windows, after options (-s 1 1 1), or with
// folders of another machine.
std::optional<fs::path> find_picture(const fs::path& scan, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  for (std::string rest = name; !rest.empty();) {
    for (const auto& tried : {fs::path(rest), fs::path(rest).filename()})
      if (const auto file = scan.parent_path() / tried; is_file(file)) return file;
    if (name.front() != '-') break;
    const auto space = rest.find(' ');
    rest = space == std::string::npos ? "" : trimmed(rest.substr(space));
  }
  return std::nullopt;
}

// RGB, or a note.
cv::Mat read_picture(const fs::path& scan, const std::string& name, std::vector<std::string>& notes) {
  const auto file = find_picture(scan, name);
  if (!file) {
    notes.push_back(fmt::format("its picture {} is missing", name));
    return {};
  }
  cv::Mat rgb;
  try {
    cv::cvtColor(decode_picture(*file, "the picture", read_whole(*file)), rgb, cv::COLOR_RGBA2RGB);
  } catch (const InvalidInput& error) {
    notes.emplace_back(error.what());
  }
  return rgb;
}

// Materials of the polygons, and of their triangles; false if none says a colour.
bool set_materials(TexturedCollector& collector, const std::map<int, int>& picture_of, TexturedMesh& textured) {
  std::map<std::pair<int, std::optional<Colour>>, int> known;
  auto& materials = textured.materials;
  textured.material.assign(textured.mesh.triangles.size(), -1);
  const auto& faces = collector.faces();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (auto t = faces[f].first; t < collector.end_of(f); ++t) {
      const auto found = picture_of.find(faces[f].texture);
      const int picture = found != picture_of.end() && collector.has_uv(t) ? found->second : -1;
      const auto colour = picture < 0 ? faces[f].colour : std::nullopt;
      if (picture < 0 && !colour) continue;
      const auto [at, is_new] = known.try_emplace({picture, colour}, static_cast<int>(materials.size()));
      if (is_new) materials.push_back({.picture = picture, .factor = colour ? linear(*colour) : Vector3f::Ones()});
      textured.material[t] = at->second;
    }
  }
  return !materials.empty();
}

}  // namespace

OpenMesh::FaceHandle TexturedCollector::add_face(const VHandles& corners) {
  faces_.push_back({.first = mesh_.triangles.size()});
  PolygonCollector::add_face(corners);
  textured_.uv.resize(mesh_.triangles.size());
  has_uv_.resize(mesh_.triangles.size(), false);
  return vertices_.new_face();  // without corners: it bears what the file says of the face
}

void TexturedCollector::add_face_texcoords(OpenMesh::FaceHandle face, OpenMesh::VertexHandle,
                                           const std::vector<OpenMesh::Vec2f>& at) {
  std::vector<Vector2f> uv;
  for (const auto& corner : at) uv.emplace_back(corner[0], corner[1]);
  set_uv(static_cast<std::size_t>(face.idx()), uv);
}

void TexturedCollector::set_uv(std::size_t face, const std::vector<Vector2f>& uv) {
  const std::size_t first = faces_[face].first;
  if (uv.size() != end_of(face) - first + 2) return;
  const auto turned = [&](std::size_t i) { return Vector2f(uv[i].x(), 1.0F - uv[i].y()); };
  for (std::size_t t = first; t < end_of(face); ++t) {
    textured_.uv[t] = {turned(0), turned(t - first + 1), turned(t - first + 2)};
    has_uv_[t] = true;
  }
}

void TexturedCollector::put_back(const std::vector<LeftOut>& left_out, const std::vector<std::size_t>& materials) {
  if (left_out.empty()) return;
  std::map<std::size_t, Face> like;  // a polygon that was read, of each material
  for (std::size_t f = 0; f < faces_.size(); ++f) like.try_emplace(materials[f], faces_[f]);
  const auto triangles = std::exchange(mesh_.triangles, {});
  const auto uv = std::exchange(textured_.uv, {});
  const auto has_uv = std::exchange(has_uv_, {});
  const auto faces = std::exchange(faces_, {});
  auto next = left_out.begin();
  for (std::size_t f = 0; f <= faces.size(); ++f) {
    for (; next != left_out.end() && next->before == f; ++next) {
      add_face(next->corners);
      set_uv(faces_.size() - 1, next->uv);
      if (const auto found = like.find(next->material); found != like.end()) {
        faces_.back().texture = found->second.texture;
        faces_.back().colour = found->second.colour;
      }
    }
    if (f == faces.size()) break;
    const auto begin = static_cast<std::ptrdiff_t>(faces[f].first);
    const auto end = static_cast<std::ptrdiff_t>(f + 1 < faces.size() ? faces[f + 1].first : triangles.size());
    faces_.push_back(faces[f]);
    faces_.back().first = mesh_.triangles.size();
    mesh_.triangles.insert(mesh_.triangles.end(), triangles.begin() + begin, triangles.begin() + end);
    textured_.uv.insert(textured_.uv.end(), uv.begin() + begin, uv.begin() + end);
    has_uv_.insert(has_uv_.end(), has_uv.begin() + begin, has_uv.begin() + end);
  }
}

void paint_polygons(const fs::path& file, TexturedCollector& collector, const std::map<int, std::string>& names,
                    TexturedMesh& textured, std::vector<std::string>& notes) {
  std::map<int, int> picture_of;
  for (const auto& [id, name] : names) {
    auto picture = read_picture(file, name, notes);
    if (picture.empty()) continue;
    picture_of[id] = static_cast<int>(textured.pictures.size());
    textured.pictures.push_back(std::move(picture));
  }
  for (const auto& colour : textured.mesh.colours) textured.shades.push_back(linear(colour));
  if (set_materials(collector, picture_of, textured)) paint_vertices(textured);
}

bool is_file(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

}  // namespace rotunda::recon
