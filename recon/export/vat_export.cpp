// A clip as a vertex animation texture: where each vertex goes stands in a picture, a row or several a frame, and a
// shader reads it. A geometry video is just that; what is added is the layout that the shaders of OpenVAT (Unity,
// Unreal, Godot) know: offsets from the mesh's own positions, 16 bits over Min ... Max of the JSON, frames from the
// top.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "recon/export/clip_surface.h"
#include "recon/export/glb_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/geometry_picture.h"

namespace rotunda::recon {
namespace {

constexpr int kLargestSide = 8192;  // of a texture: what every GPU since OpenGL ES 3 desktop parts takes

// Vertex i of frame f is pixel (i % width, f * rows + i / width).
struct VatLayout {
  int width = 0, rows = 0, height = 0;
};

VatLayout layout_of(std::size_t vertices, int frames) {
  const auto count = static_cast<int>(vertices);
  VatLayout layout;
  layout.rows = (count + kLargestSide - 1) / kLargestSide;
  layout.width = (count + layout.rows - 1) / layout.rows;
  layout.height = layout.rows * frames;
  if (layout.height > kLargestSide)
    throw InvalidInput(
        fmt::format("{} frames of {} vertices are {} rows, more than the {} of a texture; export at most "
                    "{} frames, or a coarser level",
                    frames, count, layout.height, kLargestSide, kLargestSide / layout.rows));
  return layout;
}

std::vector<Eigen::Vector2f> vat_coordinates(const VatLayout& layout, std::size_t vertices) {
  std::vector<Eigen::Vector2f> coordinates;
  for (std::size_t i = 0; i < vertices; ++i) {
    const auto x = static_cast<int>(i) % layout.width, y = static_cast<int>(i) / layout.width;
    coordinates.emplace_back((static_cast<float>(x) + 0.5F) / static_cast<float>(layout.width),
                             (static_cast<float>(y) + 0.5F) / static_cast<float>(layout.height));
  }
  return coordinates;
}

// Vectors between low and high as 16 bits, into a frame's rows.
void put_frame(cv::Mat& texture, const VatLayout& layout, int frame, const std::vector<Eigen::Vector3f>& vectors,
               const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  const Eigen::Vector3f extent = (high - low).cwiseMax(1e-9F);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const Eigen::Vector3f share = (vectors[i] - low).cwiseQuotient(extent);
    auto& pixel = texture.at<cv::Vec3w>(frame * layout.rows + static_cast<int>(i) / layout.width,
                                        static_cast<int>(i) % layout.width);
    for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<std::uint16_t>(65535.0F * share[c]);
  }
}

void write_mesh(ClipExport& clip, const std::string& name, const std::vector<Eigen::Vector3f>& base,
                const std::vector<Eigen::Vector3f>& normals, const VatLayout& layout) {
  GlbFile glb;
  std::vector<std::uint32_t> indices;
  for (const auto& t : lattice_triangles(clip.level())) indices.insert(indices.end(), t.begin(), t.end());
  clip.set_surface(base.size(), indices.size() / 3);
  const auto colours = texture_coordinates(clip.level(), clip.colour_level());
  nlohmann::json primitive{{"attributes",
                            {{"POSITION", glb.add_positions(base)},
                             {"NORMAL", glb.add_normals(normals)},
                             {"TEXCOORD_0", glb.add_texture_coordinates(colours)},
                             {"TEXCOORD_1", glb.add_texture_coordinates(vat_coordinates(layout, base.size()))}}},
                           {"indices", glb.add_indices(indices)}};
  glb.json["meshes"] = {{{"name", name}, {"primitives", {std::move(primitive)}}}};
  glb.json["nodes"] = {{{"name", name}, {"mesh", 0}}};
  glb.json["scenes"] = {{{"nodes", {0}}}};
  glb.json["scene"] = 0;
  const auto file = clip.output() / (name + ".glb");
  glb.write(file);
  clip.written(file);
}

nlohmann::json remap_info(const ClipExport& clip, const std::string& name, const VatLayout& layout,
                          const Eigen::AlignedBox3f& box) {
  const auto list = [](const Eigen::Vector3f& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
  return {{"os-remap", {{"Min", list(box.min())}, {"Max", list(box.max())}, {"Frames", clip.count()}}},
          {"animations",
           {{name, {{"startFrame", 0}, {"endFrame", clip.count() - 1}, {"framerate", clip.fps()}, {"looping", true}}}}},
          {"layout",
           {{"width", layout.width},
            {"height", layout.height},
            {"rows_per_frame", layout.rows},
            {"first_frame", "top"},
            {"positions", "offset from the mesh's own, Min to Max, y up, metres"},
            {"normals", "-1 to 1"}}}};
}

std::string name_of(const std::filesystem::path& folder) {
  auto path = folder.lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  const auto name = path.filename().string();
  return name.empty() || name == "." || name == ".." ? "clip" : name;
}

void write_texture(ClipExport& clip, const std::string& name, const cv::Mat& texture) {
  const auto file = clip.output() / name;
  write_whole(file, [&](const auto& part) { capture::write_png(part, texture); });
  clip.written(file);
}

}  // namespace

void export_vat(ClipExport& clip) {
  const auto name = name_of(clip.output());
  const auto layout = layout_of(lattice_size(clip.level()), clip.count());
  const auto colours = clip.output() / (name + "_colour");
  std::filesystem::create_directories(colours);
  cv::Mat positions = cv::Mat::zeros(layout.height, layout.width, CV_16UC3), normals = positions.clone();
  std::vector<std::vector<Eigen::Vector3f>> offsets;
  std::vector<Eigen::Vector3f> base;
  Eigen::AlignedBox3f box;
  for (int i = 0; i < clip.count(); ++i) {
    const auto image = clip.read(i);
    auto vectors = y_up(image.positions);
    const auto turned = y_up(image.normals);
    if (i == 0) {
      base = vectors;
      write_mesh(clip, name, base, turned, layout);
    }
    for (std::size_t v = 0; v < vectors.size(); ++v) box.extend(vectors[v] -= base[v]);
    offsets.push_back(std::move(vectors));
    put_frame(normals, layout, i, turned, Eigen::Vector3f::Constant(-1.0F), Eigen::Vector3f::Constant(1.0F));
    write_texture(clip, name + "_colour/" + clip.frame_name(i, "png"), colour_picture(image));
  }
  for (int i = 0; i < clip.count(); ++i)
    put_frame(positions, layout, i, offsets[static_cast<std::size_t>(i)], box.min(), box.max());
  write_texture(clip, name + "_vat.png", positions);
  write_texture(clip, name + "_vnrm.png", normals);
  const auto json = clip.output() / (name + "-remap_info.json");
  write_text(json, remap_info(clip, name, layout, box).dump(1) + "\n");
  clip.written(json);
}

}  // namespace rotunda::recon
