#include "playback/render/stage.h"

#include <opencv2/imgproc.hpp>

#include "playback/render/view_program.h"

namespace rotunda::playback {
namespace {

constexpr int kPixels = 96;          // of the shadow, a side
constexpr double kCovered = 3.0;     // metres that they cover
constexpr double kEyeHeight = 60.0;  // metres: seen from so high that rays are as good as parallel
constexpr double kNear = 0.05, kFar = 500.0;

constexpr std::string_view kVertex = R"(#version 300 es
precision highp float;
uniform mat4 u_clip_from_world;
uniform vec3 u_middle;
uniform float u_radius;
out vec2 v_place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  v_place = corner * u_radius;
  gl_Position = u_clip_from_world * vec4(u_middle.xy + v_place, u_middle.z, 1.0);
}
)";

constexpr std::string_view kFragment = R"(#version 300 es
precision highp float;
uniform sampler2D u_shadow;
uniform float u_covered, u_radius;
uniform vec2 u_world;  // of the disc's middle
uniform vec3 u_colour, u_background;
uniform bool u_opaque;
in vec2 v_place;
out vec4 o_colour;
void main() {
  float away = length(v_place) / u_radius;
  float light = 1.0 - smoothstep(0.15, 1.0, away);
  vec2 in_shadow = vec2(v_place.x, -v_place.y) / u_covered + 0.5;
  float shade = 1.0 - 0.75 * texture(u_shadow, in_shadow).r;
  vec2 lines = abs(fract((u_world + v_place) * 2.0 + 0.5) - 0.5);  // a line every half metre shows the way gone
  float line = 1.0 - 0.10 * (1.0 - smoothstep(0.0, 0.03, min(lines.x, lines.y)));
  vec3 floor_colour = u_colour * shade * line * (0.6 + 0.4 * light);
  o_colour = u_opaque ? vec4(mix(u_background, floor_colour, light), 1.0) : vec4(floor_colour, light);
}
)";

Viewpoint from_above(const StageOptions& options) {
  Viewpoint eye{.width = kPixels, .height = kPixels};
  const double focal = kPixels * kEyeHeight / kCovered, middle = 0.5 * (kPixels - 1);
  eye.K << focal, 0.0, middle, 0.0, focal, middle, 0.0, 0.0, 1.0;
  eye.R << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
  eye.t = -eye.R * Eigen::Vector3d(options.place.x(), options.place.y(), options.floor_height + kEyeHeight);
  return eye;
}

void set_colour(const GlProgram& program, const char* name, const recon::Colour& colour) {
  const auto channel = [&](std::size_t i) { return static_cast<float>(colour[i]) / 255.0F; };
  glUniform3f(uniform(program, name), channel(0), channel(1), channel(2));
}

}  // namespace

Stage::Stage()
    : outline_(kPixels, kPixels),
      shadow_(make_texture()),
      program_(make_program(kVertex, kFragment)),
      vertices_(make_vertex_array()) {
  glBindTexture(GL_TEXTURE_2D, shadow_.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_R8, kPixels, kPixels);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
}

// A lamp as large as a window: most of the shadow is wide, what lies close to the floor is sharper.
void Stage::make_shadow(const StageOptions& options, const std::function<void(const Viewpoint&)>& draw_body) {
  GLint before = 0, viewport[4] = {};
  glGetIntegerv(GL_FRAMEBUFFER_BINDING, &before);
  glGetIntegerv(GL_VIEWPORT, viewport);
  outline_.bind();
  clear(std::nullopt);
  draw_body(from_above(options));
  cv::Mat alpha, wide, narrow;
  cv::extractChannel(outline_.read_rgba(), alpha, 3);
  cv::GaussianBlur(alpha, wide, {}, 0.14 * kPixels / kCovered);
  cv::GaussianBlur(alpha, narrow, {}, 0.05 * kPixels / kCovered);
  alpha = 0.6 * wide + 0.4 * narrow;
  alpha.row(0).setTo(0);
  alpha.row(kPixels - 1).setTo(0);
  alpha.col(0).setTo(0);
  alpha.col(kPixels - 1).setTo(0);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(before));
  glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, shadow_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kPixels, kPixels, GL_RED, GL_UNSIGNED_BYTE, alpha.data);
}

void Stage::draw(const Viewpoint& viewpoint, const StageOptions& options,
                 const std::function<void(const Viewpoint&)>& draw_body) {
  if (viewpoint.eye().z() <= options.floor_height) return;  // nobody sees a floor from below
  make_shadow(options, draw_body);
  glUseProgram(program_.get());
  const Eigen::Matrix4f clip = clip_from_world(viewpoint, {kNear, kFar});
  glUniformMatrix4fv(uniform(program_, "u_clip_from_world"), 1, GL_FALSE, clip.data());
  const Eigen::Vector2f place = options.place.cast<float>();
  glUniform3f(uniform(program_, "u_middle"), place.x(), place.y(), static_cast<float>(options.floor_height));
  glUniform2f(uniform(program_, "u_world"), place.x(), place.y());
  glUniform1f(uniform(program_, "u_radius"), static_cast<float>(options.radius));
  glUniform1f(uniform(program_, "u_covered"), static_cast<float>(kCovered));
  glUniform1i(uniform(program_, "u_shadow"), 0);
  glUniform1i(uniform(program_, "u_opaque"), options.background ? 1 : 0);
  set_colour(program_, "u_colour", options.colour);
  set_colour(program_, "u_background", options.background.value_or(recon::Colour{}));
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glBindVertexArray(vertices_.get());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDepthMask(GL_TRUE);
}

}  // namespace rotunda::playback
