#include "playback/render/lattice_drawing.h"

namespace rotunda::playback {
namespace {

constexpr std::uint32_t kRestart = 0xffffffffU;

constexpr std::string_view kLattice = R"(
uniform int u_side;    // samples a side at this level of detail
uniform int u_stride;  // texels from one to the next
ivec2 lattice_place() { return ivec2(gl_VertexID % u_side, gl_VertexID / u_side); }
)";

constexpr std::string_view kSurface = R"(
vec3 sample_at(ivec2 p) {  // beyond a border line the lattice goes on by reflection about the line's middle
  int last = u_side - 1;
  if (p.y < 0) p = ivec2(last - p.x, -p.y);
  if (p.y > last) p = ivec2(last - p.x, 2 * last - p.y);
  if (p.x < 0) p = ivec2(-p.x, last - p.y);
  if (p.x > last) p = ivec2(2 * last - p.x, last - p.y);
  return at(p * u_stride);
}
vec3 place() { return at(lattice_place() * u_stride); }
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

const LatticeStrips::Strips& LatticeStrips::strips_of(int level) {
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

void LatticeStrips::draw(int level) {
  glBindVertexArray(vertices_.get());
  const Strips& strips = strips_of(level);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, strips.indices.get());
  glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  glDrawElements(GL_TRIANGLE_STRIP, strips.count, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
}

GlTexture lattice_texture(GLenum storage, int side, GLint filter) {
  GlTexture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, storage, side, side);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

void fill_texture(const GlTexture& texture, int side, GLenum format, GLenum type, const void* texels) {
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, side, side, format, type, texels);
}

void set_lattice(const GlProgram& program, int drawn_level, int stored_level, int colour_level) {
  glUniform1i(uniform(program, "u_side"), (1 << drawn_level) + 1);
  glUniform1i(uniform(program, "u_stride"), 1 << (stored_level - drawn_level));
  glUniform1f(uniform(program, "u_colour_side"), static_cast<float>((1 << colour_level) + 1));
}

std::string lattice_vertex_body(std::string_view at) {
  return std::string(kLattice).append(at).append(kSurface);
}

}  // namespace rotunda::playback
