#include "playback/render/character_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "playback/render/geometry_image_renderer.h"
#include "recon/motion/character.h"

namespace rotunda::playback {
namespace {

constexpr std::string_view kVertex = R"(
uniform highp usampler2D u_positions0;
#if LAYERS > 1
uniform highp usampler2D u_positions1;
#endif
#if LAYERS > 2
uniform highp usampler2D u_positions2;
#endif
#if LAYERS > 3
uniform highp usampler2D u_positions3;
#endif
uniform mat4 u_world_from_texel[LAYERS];  // weights are in them
uniform int u_side, u_stride;
ivec2 lattice_place() { return ivec2(gl_VertexID % u_side, gl_VertexID / u_side); }
vec3 at(ivec2 p) {
  p *= u_stride;
  vec3 sum = (u_world_from_texel[0] * vec4(texelFetch(u_positions0, p, 0).xyz, 1.0)).xyz;
#if LAYERS > 1
  sum += (u_world_from_texel[1] * vec4(texelFetch(u_positions1, p, 0).xyz, 1.0)).xyz;
#endif
#if LAYERS > 2
  sum += (u_world_from_texel[2] * vec4(texelFetch(u_positions2, p, 0).xyz, 1.0)).xyz;
#endif
#if LAYERS > 3
  sum += (u_world_from_texel[3] * vec4(texelFetch(u_positions3, p, 0).xyz, 1.0)).xyz;
#endif
  return sum;
}
vec3 sample_at(ivec2 p) {  // beyond a border line the lattice goes on by reflection about the line's middle
  int last = u_side - 1;
  if (p.y < 0) p = ivec2(last - p.x, -p.y);
  if (p.y > last) p = ivec2(last - p.x, 2 * last - p.y);
  if (p.x < 0) p = ivec2(-p.x, last - p.y);
  if (p.x > last) p = ivec2(2 * last - p.x, last - p.y);
  return at(p);
}
vec3 place() { return at(lattice_place()); }
vec3 outwards() {
  ivec2 here = lattice_place();
  vec3 across = sample_at(here + ivec2(1, 0)) - sample_at(here - ivec2(1, 0));
  vec3 down = sample_at(here + ivec2(0, 1)) - sample_at(here - ivec2(0, 1));
  return normalize(cross(across, down) + vec3(0.0, 0.0, 1e-20));
}
#ifndef GREY
uniform float u_colour_side;
out vec2 v_texel;
void paint() {  // lattice samples are texel centres
  v_texel = (vec2(lattice_place()) / float(u_side - 1) * (u_colour_side - 1.0) + 0.5) / u_colour_side;
}
#endif
)";

constexpr std::string_view kFragment = R"(
uniform sampler2D u_colours0;
#if LAYERS > 1
uniform sampler2D u_colours1;
#endif
#if LAYERS > 2
uniform sampler2D u_colours2;
#endif
#if LAYERS > 3
uniform sampler2D u_colours3;
#endif
uniform float u_weight[LAYERS];
in vec2 v_texel;
vec3 colour() {
  vec3 sum = u_weight[0] * texture(u_colours0, v_texel).rgb;
#if LAYERS > 1
  sum += u_weight[1] * texture(u_colours1, v_texel).rgb;
#endif
#if LAYERS > 2
  sum += u_weight[2] * texture(u_colours2, v_texel).rgb;
#endif
#if LAYERS > 3
  sum += u_weight[3] * texture(u_colours3, v_texel).rgb;
#endif
  return sum;
}
)";

constexpr double kLevels = 65535.0;  // of a stored position, along each side of the box

std::string with_layers(std::size_t layers, std::string_view body) {
  return fmt::format("#define LAYERS {}\n{}", layers, body);
}

GlTexture texture_of(GLenum storage, GLenum format, GLenum type, int side, GLint filter, const void* texels) {
  GlTexture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, storage, side, side);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, side, side, format, type, texels);
  return texture;
}

std::vector<std::uint16_t> coded_positions(const recon::GeometryImage& image, const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d low = box.min(), size = box.sizes().cwiseMax(1e-9);
  std::vector<std::uint16_t> coded;
  coded.reserve(image.positions.size() * 3);
  for (const auto& position : image.positions)
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double share = (static_cast<double>(position[axis]) - low[axis]) / size[axis];
      coded.push_back(static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * kLevels)));
    }
  return coded;
}

}  // namespace

struct CharacterRenderer::FrameTextures {
  GlTexture positions, colours;
};

struct CharacterRenderer::Clip {
  explicit Clip(const std::filesystem::path& file)
      : video(file), frames(static_cast<std::size_t>(video.frame_count())) {}
  recon::GeometryVideoReader video;
  std::vector<std::optional<FrameTextures>> frames;
};

struct CharacterRenderer::DrawnLayer {
  std::size_t clip;
  int frame;
  double weight;
  recon::FloorPose world_from_clip;
};

CharacterRenderer::CharacterRenderer(const std::filesystem::path& character, const recon::MotionGraph& graph)
    : vertices_(make_vertex_array()) {
  for (const auto& clip : graph.clips)
    clips_.push_back(std::make_unique<Clip>(recon::clip_video_of(character, clip.name)));
  inside_out_ = turns_inwards(clips_.front()->video.read(0));
}

CharacterRenderer::~CharacterRenderer() = default;

RootPaths CharacterRenderer::roots() const {
  RootPaths roots;
  for (const auto& clip : clips_) {
    roots.emplace_back();
    for (const auto& root : clip->video.header().root_path) roots.back().push_back(root.head<2>());
  }
  return roots;
}

Eigen::AlignedBox3d CharacterRenderer::box() const {
  Eigen::AlignedBox3d box;
  for (const auto& clip : clips_) {
    const auto& header = clip->video.header();
    for (const auto& root : header.root_path) {
      const Eigen::Vector3d up(0.0, 0.0, root.z());
      box.extend(header.box.min() + up);
      box.extend(header.box.max() + up);
    }
  }
  return box;
}

void CharacterRenderer::load(std::size_t clip, int frame) {
  if (clips_[clip]->frames[static_cast<std::size_t>(frame)]) return;
  auto& video = clips_[clip]->video;
  adopt(clip, frame, video.read_in_place(frame, video.header().level));
}

void CharacterRenderer::adopt(std::size_t clip, int frame, const recon::GeometryImage& image) {
  auto& textures = clips_[clip]->frames[static_cast<std::size_t>(frame)];
  if (textures) return;
  const auto coded = coded_positions(image, clips_[clip]->video.header().box);
  textures.emplace();
  textures->positions =
      texture_of(GL_RGB16UI, GL_RGB_INTEGER, GL_UNSIGNED_SHORT, image.side(), GL_NEAREST, coded.data());
  textures->colours =
      texture_of(GL_RGB8, GL_RGB, GL_UNSIGNED_BYTE, image.colour_side(), GL_LINEAR, image.colours.data());
  texture_bytes_ += 6 * image.positions.size() + 3 * image.colours.size();
}

void CharacterRenderer::load_all(const std::function<void(std::size_t done, std::size_t total)>& progress) {
  std::size_t total = 0, done = 0;
  for (const auto& clip : clips_) total += clip->frames.size();
  for (std::size_t i = 0; i < clips_.size(); ++i)
    for (int frame = 0; frame < clips_[i]->video.frame_count(); ++frame) {
      load(i, frame);
      if (progress) progress(++done, total);
    }
}

// Between two frames both are drawn by their shares; what is faintest is left out where there are too many.
std::vector<CharacterRenderer::DrawnLayer> CharacterRenderer::drawn_layers(const Appearance& appearance) {
  constexpr double kFaint = 1e-4;
  std::vector<DrawnLayer> drawn;
  for (const auto& layer : appearance.layers) {
    const int last = clips_[layer.clip]->video.frame_count() - 1, frame = std::min(static_cast<int>(layer.frame), last);
    const double part = layer.frame - frame;
    const auto add = [&](int at, double share) {
      if (share * layer.weight > kFaint) drawn.push_back({layer.clip, at, share * layer.weight, layer.world_from_clip});
    };
    add(frame, frame == last ? 1.0 : 1.0 - part);
    if (frame < last) add(frame + 1, part);
  }
  std::stable_sort(drawn.begin(), drawn.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
  if (drawn.size() > kMostLayers) drawn.erase(drawn.begin() + kMostLayers, drawn.end());
  double sum = 0.0;
  for (const auto& layer : drawn) sum += layer.weight;
  for (auto& layer : drawn) layer.weight /= sum;
  for (const auto& layer : drawn) load(layer.clip, layer.frame);
  return drawn;
}

void CharacterRenderer::bind(const GlProgram& program, const std::vector<DrawnLayer>& layers, int drawn_level) {
  const auto& header = clips_[layers.front().clip]->video.header();
  glUniform1i(uniform(program, "u_side"), (1 << drawn_level) + 1);
  glUniform1i(uniform(program, "u_stride"), 1 << (header.level - drawn_level));
  glUniform1f(uniform(program, "u_colour_side"), static_cast<float>((1 << header.colour_level) + 1));
  std::vector<float> places, weights;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const auto& layer = layers[i];
    const auto& video = clips_[layer.clip]->video.header();
    const auto& textures = *clips_[layer.clip]->frames[static_cast<std::size_t>(layer.frame)];
    const auto unit = static_cast<GLint>(2 * i);
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
    glBindTexture(GL_TEXTURE_2D, textures.positions.get());
    glUniform1i(uniform(program, fmt::format("u_positions{}", i).c_str()), unit);
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit + 1));
    glBindTexture(GL_TEXTURE_2D, textures.colours.get());
    glUniform1i(uniform(program, fmt::format("u_colours{}", i).c_str()), unit + 1);
    const auto& pose = layer.world_from_clip;
    Eigen::Matrix4d world = Eigen::Matrix4d::Identity(), texel = Eigen::Matrix4d::Identity();
    world.topLeftCorner<2, 2>() << std::cos(pose.yaw), -std::sin(pose.yaw), std::sin(pose.yaw), std::cos(pose.yaw);
    world.topRightCorner<2, 1>() << pose.x, pose.y;
    texel.topLeftCorner<3, 3>() = (video.box.sizes() / kLevels).asDiagonal();
    texel.topRightCorner<3, 1>() = video.box.min() + video.root_path[static_cast<std::size_t>(layer.frame)];
    const Eigen::Matrix4f place = (layer.weight * (world * texel)).cast<float>();
    places.insert(places.end(), place.data(), place.data() + 16);
    weights.push_back(static_cast<float>(layer.weight));
  }
  glUniformMatrix4fv(uniform(program, "u_world_from_texel"), static_cast<GLsizei>(layers.size()), GL_FALSE,
                     places.data());
  glUniform1fv(uniform(program, "u_weight"), static_cast<GLsizei>(layers.size()), weights.data());
}

const CharacterRenderer::Strips& CharacterRenderer::strips_of(int level) {
  Strips& strips = strips_[level];
  if (strips.count > 0) return strips;
  const auto indices = lattice_strips(level);
  strips.indices = make_buffer();
  strips.count = static_cast<GLsizei>(indices.size());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, strips.indices.get());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(indices[0])), indices.data(),
               GL_STATIC_DRAW);
  return strips;
}

void CharacterRenderer::draw(const Appearance& appearance, const Viewpoint& viewpoint, const DrawOptions& options,
                             int level) {
  const auto layers = drawn_layers(appearance);
  const int finest = clips_.front()->video.header().level, drawn = level > 0 ? std::min(level, finest) : finest;
  auto& program = programs_[layers.size() - 1];
  if (!program) program.emplace(with_layers(layers.size(), kVertex), with_layers(layers.size(), kFragment));
  Eigen::AlignedBox3d around = box();
  around.translate(Eigen::Vector3d(appearance.place.x(), appearance.place.y(), 0.0));
  around.min().head<2>().array() -= 1.0;  // the box may be turned
  around.max().head<2>().array() += 1.0;
  const GlProgram& used = program->use(viewpoint, depth_range(viewpoint, around), options);
  if (inside_out_) glFrontFace(viewpoint.mirrored() ? GL_CCW : GL_CW);
  bind(used, layers, drawn);
  glBindVertexArray(vertices_.get());
  const Strips& strips = strips_of(drawn);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, strips.indices.get());
  glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  glDrawElements(GL_TRIANGLE_STRIP, strips.count, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
}

}  // namespace rotunda::playback
