// A clip as one glTF file. There is no sequence of meshes in glTF 2.0. Two ways to have one are opened everywhere: a
// mesh a frame, all but one shrunk to nothing (each with its own colours); or one mesh with a morph target a frame (one
// set of colours, true to all frames only if each vertex is the same spot of the performer in all).
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/export/clip_surface.h"
#include "recon/export/glb_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/geometry_picture.h"

namespace rotunda::recon {
namespace {

std::vector<std::uint8_t> png_of(const cv::Mat& rgb) {
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> png;
  if (!cv::imencode(".png", bgr, png)) throw InvalidInput("the colours cannot be made a PNG picture");
  return png;
}

std::vector<float> frame_times(const ClipExport& clip) {
  std::vector<float> times;
  for (int i = 0; i < clip.count(); ++i) times.push_back(static_cast<float>(i / clip.fps()));
  return times;
}

std::string frame_title(const ClipExport& clip, int index) {
  return std::filesystem::path(clip.frame_name(index, "glb")).stem().string();
}

// What all frames share.
struct Lattice {
  std::size_t indices, texture_coordinates;  // accessors
};

Lattice add_lattice(GlbFile& glb, ClipExport& clip) {
  std::vector<std::uint32_t> indices;
  for (const auto& t : lattice_triangles(clip.level())) indices.insert(indices.end(), t.begin(), t.end());
  clip.set_surface(lattice_size(clip.level()), indices.size() / 3);
  return {glb.add_indices(indices),
          glb.add_texture_coordinates(texture_coordinates(clip.level(), clip.colour_level()))};
}

nlohmann::json primitive_of(GlbFile& glb, const Lattice& lattice, const std::vector<Eigen::Vector3f>& positions,
                            const GeometryImage& coloured) {
  return {{"attributes", {{"POSITION", glb.add_positions(positions)}, {"TEXCOORD_0", lattice.texture_coordinates}}},
          {"indices", lattice.indices},
          {"material", glb.add_unlit_material(glb.add_png(png_of(colour_picture(coloured))))}};
}

// Every frame's size over all frames' times: one at its own, nothing at the others.
void add_sizes(GlbFile& glb, const ClipExport& clip) {
  auto& animation = glb.json["animations"][0];
  animation = {{"name", "clip"}};
  const auto times = glb.add_scalars(frame_times(clip));
  for (int frame = 0; frame < clip.count(); ++frame) {
    std::vector<Eigen::Vector3f> sizes(static_cast<std::size_t>(clip.count()), Eigen::Vector3f::Zero());
    sizes[static_cast<std::size_t>(frame)].setOnes();
    animation["samplers"].push_back({{"input", times}, {"output", glb.add_values(sizes)}, {"interpolation", "STEP"}});
    animation["channels"].push_back({{"sampler", frame}, {"target", {{"node", frame}, {"path", "scale"}}}});
  }
}

void add_mesh_a_frame(GlbFile& glb, ClipExport& clip) {
  const auto lattice = add_lattice(glb, clip);
  for (int i = 0; i < clip.count(); ++i) {
    const auto image = clip.read(i);
    const auto title = frame_title(clip, i);
    glb.json["meshes"].push_back(
        {{"name", title}, {"primitives", {primitive_of(glb, lattice, y_up(image.positions), image)}}});
    nlohmann::json node{{"name", title}, {"mesh", i}};
    if (i > 0) node["scale"] = {0.0, 0.0, 0.0};
    glb.json["nodes"].push_back(std::move(node));
    glb.json["scenes"][0]["nodes"].push_back(i);
  }
  if (clip.count() > 1) add_sizes(glb, clip);
}

// Frame i is the base mesh for i = 0, else the base mesh with target i - 1 alone at weight 1.
void add_weights(GlbFile& glb, const ClipExport& clip) {
  const auto frames = static_cast<std::size_t>(clip.count()), targets = frames - 1;
  std::vector<float> weights(frames * targets, 0.0F);
  for (std::size_t i = 1; i < frames; ++i) weights[i * targets + i - 1] = 1.0F;
  const auto input = glb.add_scalars(frame_times(clip)), output = glb.add_scalars(weights);
  glb.json["animations"] = {{{"name", "clip"},
                             {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "STEP"}}}},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  glb.json["meshes"][0]["weights"] = std::vector<float>(targets, 0.0F);
}

void add_morph_targets(GlbFile& glb, ClipExport& clip) {
  const auto lattice = add_lattice(glb, clip);
  const auto first = clip.read(0);
  const auto base = y_up(first.positions);
  auto primitive = primitive_of(glb, lattice, base, first);
  nlohmann::json names = nlohmann::json::array();
  for (int i = 1; i < clip.count(); ++i) {
    auto offsets = y_up(clip.read(i).positions);
    for (std::size_t v = 0; v < offsets.size(); ++v) offsets[v] -= base[v];
    primitive["targets"].push_back({{"POSITION", glb.add_positions(offsets)}});
    names.push_back(frame_title(clip, i));
  }
  glb.json["meshes"] = {{{"name", "performer"}, {"primitives", {std::move(primitive)}}}};
  glb.json["nodes"] = {{{"name", "performer"}, {"mesh", 0}}};
  glb.json["scenes"] = {{{"nodes", {0}}}};
  if (clip.count() == 1) return;
  glb.json["meshes"][0]["extras"]["targetNames"] = std::move(names);
  add_weights(glb, clip);
}

}  // namespace

void export_glb(ClipExport& clip) {
  GlbFile glb;
  if (clip.morph())
    add_morph_targets(glb, clip);
  else
    add_mesh_a_frame(glb, clip);
  glb.json["scene"] = 0;
  glb.write(clip.output());
  clip.written(clip.output());
}

}  // namespace rotunda::recon
