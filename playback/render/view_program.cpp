#include "playback/render/view_program.h"

#include <string>

namespace rotunda::playback {
namespace {

constexpr std::string_view kVertexHead = R"(
uniform mat4 u_eye_from_world;
uniform mat3 u_device_from_ideal;
uniform vec2 u_depth;  // clip z = x * depth + y
#ifdef DISTORTED
uniform float u_distortion[5];  // k1 k2 p1 p2 k3
uniform float u_fold;           // squared radius beyond which the lens folds over
out float v_beyond;
#endif
#ifdef LAMP
uniform vec3 u_eye;
out vec3 v_normal, v_to_eye;
#endif
vec3 place();
vec3 outwards();
void paint();
vec4 clip_of(vec3 in_eye) {
  vec2 image = in_eye.xy;  // ideal image plane, times depth
#ifdef DISTORTED
  v_beyond = 0.0;
  if (in_eye.z > 0.0) {
    vec2 p = image / in_eye.z;
    float r2 = dot(p, p);
    v_beyond = r2 > u_fold ? 1.0 : 0.0;
    float radial = 1.0 + r2 * (u_distortion[0] + r2 * (u_distortion[1] + r2 * u_distortion[4]));
    vec2 tangential = vec2(2.0 * u_distortion[2] * p.x * p.y + u_distortion[3] * (r2 + 2.0 * p.x * p.x),
                           u_distortion[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * u_distortion[3] * p.x * p.y);
    image = (p * radial + tangential) * in_eye.z;
  }
#endif
  return vec4((u_device_from_ideal * vec3(image, in_eye.z)).xy, u_depth.x * in_eye.z + u_depth.y, in_eye.z);
}
void main() {
  vec3 in_world = place();
  gl_Position = clip_of((u_eye_from_world * vec4(in_world, 1.0)).xyz);
#ifdef LAMP
  v_normal = outwards();
  v_to_eye = u_eye - in_world;
#endif
#ifndef GREY
  paint();
#endif
}
)";

constexpr std::string_view kFragmentHead = R"(
out vec4 o_colour;
#ifdef DISTORTED
in float v_beyond;
#endif
#ifdef LAMP
in vec3 v_normal, v_to_eye;
#endif
#ifndef GREY
vec3 colour();
#endif
void main() {
#ifdef DISTORTED
  if (v_beyond > 0.0) discard;
#endif
#ifdef LAMP
  float light = 0.25 + 0.6 * abs(dot(normalize(v_normal), normalize(v_to_eye)));
#else
  float light = 1.0;
#endif
#ifdef GREY
  o_colour = vec4(vec3(light), 1.0);
#else
  o_colour = vec4(light * colour(), 1.0);
#endif
}
)";

std::string source_of(std::string_view head, std::string_view body, Shading shading, bool distorted) {
  std::string source = "#version 300 es\nprecision highp float;\nprecision highp int;\n";
  if (shading == Shading::grey) source += "#define GREY\n";
  if (shading != Shading::colour) source += "#define LAMP\n";
  if (distorted) source += "#define DISTORTED\n";
  return source.append(head).append(body);
}

void set_depth(const GlProgram& program, const DepthRange& range) {
  const double n = range.near_plane, f = range.far_plane;
  glUniform2f(uniform(program, "u_depth"), static_cast<float>((f + n) / (f - n)),
              static_cast<float>(-2.0 * f * n / (f - n)));
}

void set_viewpoint(const GlProgram& program, const Viewpoint& viewpoint) {
  Eigen::Matrix4f eye_from_world = Eigen::Matrix4f::Identity();
  eye_from_world.topLeftCorner<3, 3>() = viewpoint.R.cast<float>();
  eye_from_world.topRightCorner<3, 1>() = viewpoint.t.cast<float>();
  glUniformMatrix4fv(uniform(program, "u_eye_from_world"), 1, GL_FALSE, eye_from_world.data());
  const Eigen::Matrix3f device = device_from_ideal(viewpoint).cast<float>();
  glUniformMatrix3fv(uniform(program, "u_device_from_ideal"), 1, GL_FALSE, device.data());
  const Eigen::Vector3f eye = viewpoint.eye().cast<float>();
  glUniform3fv(uniform(program, "u_eye"), 1, eye.data());
  const Eigen::Matrix<float, 5, 1> distortion = viewpoint.distortion.cast<float>();
  glUniform1fv(uniform(program, "u_distortion"), 5, distortion.data());
  glUniform1f(uniform(program, "u_fold"), static_cast<float>(fold_radius_squared(viewpoint)));
}

void set_culling(const Viewpoint& viewpoint, bool cull) {
  if (!cull) return glDisable(GL_CULL_FACE);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glFrontFace(viewpoint.mirrored() ? GL_CW : GL_CCW);
}

}  // namespace

void clear(const std::optional<recon::Colour>& background) {
  const auto channel = [&](std::size_t i) { return background ? static_cast<float>((*background)[i]) / 255.0F : 0.0F; };
  glClearColor(channel(0), channel(1), channel(2), background ? 1.0F : 0.0F);
  glDepthMask(GL_TRUE);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

Eigen::Matrix4f clip_from_world(const Viewpoint& viewpoint, const DepthRange& range) {
  const double n = range.near_plane, f = range.far_plane;
  Eigen::Matrix<double, 3, 4> in_eye;
  in_eye << viewpoint.R, viewpoint.t;
  const Eigen::Matrix<double, 3, 4> on_device = device_from_ideal(viewpoint) * in_eye;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip.topRows<2>() = on_device.topRows<2>();
  clip.row(2) = (f + n) / (f - n) * in_eye.row(2);
  clip(2, 3) -= 2.0 * f * n / (f - n);
  clip.row(3) = in_eye.row(2);
  return clip.cast<float>();
}

ViewProgram::ViewProgram(std::string_view vertex_body, std::string_view fragment_body)
    : vertex_body_(vertex_body), fragment_body_(fragment_body) {}

const GlProgram& ViewProgram::use(const Viewpoint& viewpoint, const DepthRange& range, const DrawOptions& options) {
  const bool grey = options.shading == Shading::grey, distorted = !viewpoint.distortion.isZero(0.0);
  auto& program = programs_[2U * static_cast<std::size_t>(options.shading) + (distorted ? 1U : 0U)];
  if (!program)
    program = make_program(source_of(kVertexHead, vertex_body_, options.shading, distorted),
                           source_of(kFragmentHead, grey ? "" : fragment_body_, options.shading, distorted));
  glUseProgram(program->get());
  set_viewpoint(*program, viewpoint);
  set_depth(*program, range);
  set_culling(viewpoint, options.cull);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  return *program;
}

}  // namespace rotunda::playback
