#pragma once
// What all renderers of geometry images share: textures of the closed octahedral lattice, its triangle strips and the
// shader text that walks over it. Needs a current GLES 3 context.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "playback/render/gl_objects.h"

namespace rotunda::playback {

// Triangle strips of the closed lattice, (2^level + 1)^2 samples row by row, 0xffffffff between strips. Quads are cut
// along the octahedron's own edges; columns cross rows is the front.
std::vector<std::uint32_t> lattice_strips(int level);

// Index buffers by level, made when first drawn.
class LatticeStrips {
 public:
  LatticeStrips() : vertices_(make_vertex_array()) {}
  // With the program in use: every vertex number is a sample's.
  void draw(int level);

 private:
  struct Strips {
    GlBuffer indices;
    GLsizei count = 0;
  };
  const Strips& strips_of(int level);

  GlVertexArray vertices_;  // holds no attributes: the vertex number says it all
  std::map<int, Strips> strips_;
};

// side x side texels, not repeated; positions need GL_NEAREST, colours GL_LINEAR. `fill` may come later.
GlTexture lattice_texture(GLenum storage, int side, GLint filter);
void fill_texture(const GlTexture& texture, int side, GLenum format, GLenum type, const void* texels);

// The level drawn, of how many texels a side the textures have.
void set_lattice(const GlProgram& program, int drawn_level, int stored_level, int colour_level);

// A vertex shader's body: place(), outwards(), paint() of view_program.h over `vec3 at(ivec2 texel)`, world, which the
// caller gives as text. It hands `v_texel` on to the fragment shader.
std::string lattice_vertex_body(std::string_view at);

}  // namespace rotunda::playback
