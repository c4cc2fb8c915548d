#include "playback/render/geometry_image_renderer.h"

#include "config/errors.h"

namespace rotunda::playback {
namespace {

constexpr std::uint32_t kRestart = 0xffffffffU;

constexpr std::string_view kVertex = R"(
uniform highp sampler2D u_positions;
uniform int u_side;    // samples a side at this level of detail
uniform int u_stride;  // texels from one to the next
ivec2 lattice_place() { return ivec2(gl_VertexID % u_side, gl_VertexID / u_side); }
vec3 sample_at(ivec2 p) {  // beyond a border line the lattice goes on by reflection about the line's middle
  int last = u_side - 1;
  if (p.y < 0) p = ivec2(last - p.x, -p.y);
  if (p.y > last) p = ivec2(last - p.x, 2 * last - p.y);
  if (p.x < 0) p = ivec2(-p.x, last - p.y);
  if (p.x > last) p = ivec2(2 * last - p.x, last - p.y);
  return texelFetch(u_positions, p * u_stride, 0).xyz;
}
vec3 place() { return texelFetch(u_positions, lattice_place() * u_stride, 0).xyz; }
vec3 outwards() {  // the vector area of the ring of eight around the sample
  const ivec2 ring[8] = ivec2[8](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1), ivec2(-1, 0), ivec2(-1, -1),
                                 ivec2(0, -1), ivec2(1, -1));
  ivec2 here = lattice_place();
  vec3 centre = place();
  vec3 previous = sample_at(here + ring[7]) - centre;
  vec3 area = vec3(0.0);
  for (int i = 0; i < 8; ++i) {
    vec3 next = sample_at(here + ring[i]) - centre;
    area += cross(previous, next);
    previous = next;
  }
  return normalize(area + vec3(0.0, 0.0, 1e-20));
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
uniform sampler2D u_colours;
in vec2 v_texel;
vec3 colour() { return texture(u_colours, v_texel).rgb; }
)";

void set_storage(const GlTexture& texture, GLenum format, int side, GLint filter) {
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, format, side, side);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void check_image(const recon::GeometryImage& image) {
  constexpr int kFinestLevel = 12;  // textures of 4097 texels a side
  if (image.level < 1 || image.level > kFinestLevel || image.colour_level < 1 || image.colour_level > kFinestLevel)
    throw InvalidInput("a geometry image to draw has a level out of 1 to 12");
  const auto texels = [](int side) { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); };
  if (image.positions.size() != texels(image.side()) || image.colours.size() != texels(image.colour_side()))
    throw InvalidInput("a geometry image to draw has fewer positions or colours than its levels say");
}

// One strip of quads between two rows. `falling`: quads are cut from their upper left to their lower right.
void append_strip(std::vector<std::uint32_t>& strips, std::uint32_t upper, std::uint32_t lower, std::uint32_t quads,
                  bool falling) {
  if (!falling) strips.push_back(upper);  // twice the first: turns the strip's winding
  for (std::uint32_t i = 0; i <= quads; ++i) {
    strips.push_back(falling ? lower + i : upper + i);
    strips.push_back(falling ? upper + i : lower + i);
  }
  strips.push_back(kRestart);
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

std::vector<std::uint32_t> lattice_strips(int level) {
  const std::uint32_t quads = 1U << level, half = quads / 2, side = quads + 1;
  std::vector<std::uint32_t> strips;
  for (std::uint32_t row = 0; row < quads; ++row) {
    const std::uint32_t upper = row * side, lower = upper + side;
    const bool in_upper_half = row < half;  // upper left and lower right quarters are cut the rising way
    append_strip(strips, upper, lower, half, !in_upper_half);
    append_strip(strips, upper + half, lower + half, half, in_upper_half);
  }
  return strips;
}

GeometryImageRenderer::GeometryImageRenderer() : program_(kVertex, kFragment), vertices_(make_vertex_array()) {}

void GeometryImageRenderer::upload(const recon::GeometryImage& image) {
  check_image(image);
  current_ = (current_ + 1) % slots_.size();
  Slot& slot = slots_[current_];
  if (slot.level != image.level || slot.colour_level != image.colour_level) {
    slot.positions = make_texture();
    slot.colours = make_texture();
    set_storage(slot.positions, GL_RGB32F, image.side(), GL_NEAREST);
    set_storage(slot.colours, GL_RGB8, image.colour_side(), GL_LINEAR);
    slot.level = image.level;
    slot.colour_level = image.colour_level;
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glBindTexture(GL_TEXTURE_2D, slot.positions.get());
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.side(), image.side(), GL_RGB, GL_FLOAT, image.positions.data());
  glBindTexture(GL_TEXTURE_2D, slot.colours.get());
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.colour_side(), image.colour_side(), GL_RGB, GL_UNSIGNED_BYTE,
                  image.colours.data());
  slot.inside_out = turns_inwards(image);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : image.positions) box.extend(position);
  slot.box = box.cast<double>();
}

const GeometryImageRenderer::Strips& GeometryImageRenderer::strips_of(int level) {
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

void GeometryImageRenderer::draw(const Viewpoint& viewpoint, const DrawOptions& options, int level) {
  const Slot& slot = slots_[current_];
  if (slot.level == 0) return;
  const int drawn = level > 0 ? std::min(level, slot.level) : slot.level;
  const GlProgram& program = program_.use(viewpoint, depth_range(viewpoint, slot.box), options);
  if (slot.inside_out) glFrontFace(viewpoint.mirrored() ? GL_CCW : GL_CW);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, slot.colours.get());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, slot.positions.get());
  glUniform1i(uniform(program, "u_positions"), 0);
  glUniform1i(uniform(program, "u_colours"), 1);
  glUniform1i(uniform(program, "u_side"), (1 << drawn) + 1);
  glUniform1i(uniform(program, "u_stride"), 1 << (slot.level - drawn));
  glUniform1f(uniform(program, "u_colour_side"), static_cast<float>((1 << slot.colour_level) + 1));
  glBindVertexArray(vertices_.get());
  const Strips& strips = strips_of(drawn);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, strips.indices.get());
  glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  glDrawElements(GL_TRIANGLE_STRIP, strips.count, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
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
