#include "playback/render/geometry_image_renderer.h"

#include "config/errors.h"

namespace rotunda::playback {
namespace {

constexpr std::string_view kAt = R"(
uniform highp sampler2D u_positions;
vec3 at(ivec2 texel) { return texelFetch(u_positions, texel, 0).xyz; }
)";

constexpr std::string_view kFragment = R"(
uniform sampler2D u_colours;
in vec2 v_texel;
vec3 colour() { return texture(u_colours, v_texel).rgb; }
)";

constexpr std::string_view kAtBetween = R"(
uniform highp sampler2D u_positions;
uniform highp sampler2D u_next_positions;
uniform float u_share;
vec3 at(ivec2 texel) {
  return mix(texelFetch(u_positions, texel, 0).xyz, texelFetch(u_next_positions, texel, 0).xyz, u_share);
}
)";

constexpr std::string_view kFragmentBetween = R"(
uniform sampler2D u_colours;
uniform sampler2D u_next_colours;
uniform float u_share;
in vec2 v_texel;
vec3 colour() { return mix(texture(u_colours, v_texel).rgb, texture(u_next_colours, v_texel).rgb, u_share); }
)";

void check_image(const recon::GeometryImage& image) {
  constexpr int kFinestLevel = 12;  // textures of 4097 texels a side
  if (image.level < 1 || image.level > kFinestLevel || image.colour_level < 1 || image.colour_level > kFinestLevel)
    throw InvalidInput("a geometry image to draw has a level out of 1 to 12");
  const auto texels = [](int side) { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); };
  if (image.positions.size() != texels(image.side()) || image.colours.size() != texels(image.colour_side()))
    throw InvalidInput("a geometry image to draw has fewer positions or colours than its levels say");
}

}  // namespace

// By the sign of the volume within a coarse copy of the surface.
bool turns_inwards(const recon::GeometryImage& image) {
  const int side = image.side(), stride = std::max(1, side / 32);
  const auto at = [&](int row, int column) -> const Eigen::Vector3f& {
    return image.positions[static_cast<std::size_t>(row * side + column)];
  };
  const Eigen::Vector3f middle = at(side / 2, side / 2);
  float volume = 0.0F;
  for (int row = 0; row + stride < side; row += stride)
    for (int column = 0; column + stride < side; column += stride) {
      const Eigen::Vector3f a = at(row, column) - middle, b = at(row, column + stride) - middle;
      const Eigen::Vector3f c = at(row + stride, column) - middle, d = at(row + stride, column + stride) - middle;
      volume += (d - a).cross(c - b).dot(a + b + c + d);
    }
  return volume < 0.0F;
}

GeometryImageRenderer::GeometryImageRenderer()
    : program_(lattice_vertex_body(kAt), kFragment), between_(lattice_vertex_body(kAtBetween), kFragmentBetween) {}

void GeometryImageRenderer::upload(const recon::GeometryImage& image) {
  check_image(image);
  current_ = next_ = free_slot(next_);
  share_ = 0.0F;
  fill(slots_[current_], image);
  slots_[current_].frame.reset();
}

void GeometryImageRenderer::upload_between(const Numbered& from, const Numbered& to, double share) {
  check_image(from.image);
  check_image(to.image);
  if (from.image.level != to.image.level || from.image.colour_level != to.image.colour_level)
    throw InvalidInput("two geometry images of unlike levels have nothing between them");
  const auto first = slot_of(from, kSlots);
  const auto second = slot_of(to, first);
  current_ = first;
  next_ = second;
  share_ = static_cast<float>(share);
}

std::size_t GeometryImageRenderer::slot_of(const Numbered& numbered, std::size_t taken) {
  for (std::size_t i = 0; i < kSlots; ++i)
    if (slots_[i].level == numbered.image.level && slots_[i].frame == numbered.frame) return i;
  const auto free = free_slot(taken);
  fill(slots_[free], numbered.image);
  slots_[free].frame = numbered.frame;
  return free;
}

// If possible none that is drawn now.
std::size_t GeometryImageRenderer::free_slot(std::size_t taken) const {
  for (std::size_t i = 0; i < kSlots; ++i)
    if (i != taken && i != current_ && i != next_) return i;
  return (taken + 1) % kSlots;
}

void GeometryImageRenderer::fill(Slot& slot, const recon::GeometryImage& image) {
  if (slot.level != image.level || slot.colour_level != image.colour_level) {
    slot.positions = lattice_texture(GL_RGB32F, image.side(), GL_NEAREST);
    slot.colours = lattice_texture(GL_RGB8, image.colour_side(), GL_LINEAR);
    slot.level = image.level;
    slot.colour_level = image.colour_level;
  }
  fill_texture(slot.positions, image.side(), GL_RGB, GL_FLOAT, image.positions.data());
  fill_texture(slot.colours, image.colour_side(), GL_RGB, GL_UNSIGNED_BYTE, image.colours.data());
  slot.inside_out = turns_inwards(image);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : image.positions) box.extend(position);
  slot.box = box.cast<double>();
}

void GeometryImageRenderer::bind(const GlProgram& program, const Slot& slot, GLint unit, const char* positions,
                                 const char* colours) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, slot.positions.get());
  glUniform1i(uniform(program, positions), unit);
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit + 1));
  glBindTexture(GL_TEXTURE_2D, slot.colours.get());
  glUniform1i(uniform(program, colours), unit + 1);
}

void GeometryImageRenderer::draw(const Viewpoint& viewpoint, const DrawOptions& options, int level) {
  const Slot &slot = slots_[current_], &next = slots_[next_];
  if (slot.level == 0) return;
  const bool is_between = share_ > 0.0F;
  const int drawn = level > 0 ? std::min(level, slot.level) : slot.level;
  const GlProgram& program =
      (is_between ? between_ : program_).use(viewpoint, depth_range(viewpoint, slot.box.merged(next.box)), options);
  if (slot.inside_out) glFrontFace(viewpoint.mirrored() ? GL_CCW : GL_CW);
  bind(program, slot, 0, "u_positions", "u_colours");
  if (is_between) {
    bind(program, next, 2, "u_next_positions", "u_next_colours");
    glUniform1f(uniform(program, "u_share"), share_);
  }
  set_lattice(program, drawn, slot.level, slot.colour_level);
  strips_.draw(drawn);
}

cv::Mat render_geometry_image(const recon::GeometryImage& image, const Viewpoint& viewpoint, const DrawOptions& options,
                              const std::optional<recon::Colour>& background) {
  const RenderTarget target(viewpoint.width, viewpoint.height);
  GeometryImageRenderer renderer;
  renderer.upload(image);
  target.bind();
  clear(background);
  renderer.draw(viewpoint, options);
  return target.read_rgba();
}

}  // namespace rotunda::playback
