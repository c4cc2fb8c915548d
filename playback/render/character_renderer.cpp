#include "playback/render/character_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "playback/render/geometry_image_renderer.h"
#include "recon/motion/character.h"

namespace rotunda::playback {
namespace {

// A line for each layer, with its number in it.
std::string each_layer(std::size_t layers, std::string_view line) {
  std::string text;
  for (std::size_t i = 0; i < layers; ++i) text += fmt::format(fmt::runtime(line), i);
  return text;
}

std::string vertex_body(std::size_t layers) {
  const auto positions = each_layer(layers, "uniform highp usampler2D u_positions{0};\n");
  const auto sum = each_layer(
      layers, "  sum += (u_world_from_texel[{0}] * vec4(texelFetch(u_positions{0}, texel, 0).xyz, 1.0)).xyz;\n");
  return lattice_vertex_body(positions +
                             fmt::format("uniform mat4 u_world_from_texel[{}];  // weights are in them\n", layers) +
                             "vec3 at(ivec2 texel) {\n  vec3 sum = vec3(0.0);\n" + sum + "  return sum;\n}\n");
}

std::string fragment_body(std::size_t layers) {
  const auto colours = each_layer(layers, "uniform sampler2D u_colours{0};\n");
  const auto sum = each_layer(layers, "  sum += u_weight[{0}] * texture(u_colours{0}, v_texel).rgb;\n");
  return colours + fmt::format("uniform float u_weight[{}];\n", layers) +
         "in vec2 v_texel;\nvec3 colour() {\n  vec3 sum = vec3(0.0);\n" + sum + "  return sum;\n}\n";
}

constexpr double kLevels = 65535.0;  // of a stored position, along each side of the box

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

CharacterRenderer::CharacterRenderer(const std::filesystem::path& character, const recon::MotionGraph& graph) {
  for (const auto& clip : graph.clips)
    clips_.push_back(std::make_unique<Clip>(recon::clip_video_of(character, clip.name)));
  inside_out_ = turns_inwards(clips_.front()->video.read(0));
}

CharacterRenderer::~CharacterRenderer() = default;

int CharacterRenderer::level() const {
  return clips_.front()->video.header().level;
}

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
  textures->positions = lattice_texture(GL_RGB16UI, image.side(), GL_NEAREST);
  textures->colours = lattice_texture(GL_RGB8, image.colour_side(), GL_LINEAR);
  fill_texture(textures->positions, image.side(), GL_RGB_INTEGER, GL_UNSIGNED_SHORT, coded.data());
  fill_texture(textures->colours, image.colour_side(), GL_RGB, GL_UNSIGNED_BYTE, image.colours.data());
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
  set_lattice(program, drawn_level, header.level, header.colour_level);
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

void CharacterRenderer::draw(const Appearance& appearance, const Viewpoint& viewpoint, const DrawOptions& options,
                             int level) {
  const auto layers = drawn_layers(appearance);
  const int drawn = level > 0 ? std::min(level, this->level()) : this->level();
  auto& program = programs_[layers.size() - 1];
  if (!program) program.emplace(vertex_body(layers.size()), fragment_body(layers.size()));
  Eigen::AlignedBox3d around = box();
  around.translate(Eigen::Vector3d(appearance.place.x(), appearance.place.y(), 0.0));
  around.min().head<2>().array() -= 1.0;  // the box may be turned
  around.max().head<2>().array() += 1.0;
  const GlProgram& used = program->use(viewpoint, depth_range(viewpoint, around), options);
  if (inside_out_) glFrontFace(viewpoint.mirrored() ? GL_CCW : GL_CW);
  bind(used, layers, drawn);
  strips_.draw(drawn);
}

}  // namespace rotunda::playback
