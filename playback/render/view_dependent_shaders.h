#pragma once
// The shaders of view_dependent_renderer.cpp. Pictures drawn by GL have their last row first; those uploaded from
// cameras their first.
#include <string_view>

namespace rotunda::playback::view_dependent {

inline constexpr std::string_view kSurface = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec3 a_colour;
out vec3 v_place, v_normal, v_colour;
vec3 place() { return a_position; }
vec3 outwards() { return a_normal; }
void paint() {
  v_place = a_position;
  v_normal = a_normal;
  v_colour = a_colour;
}
)";
inline constexpr std::string_view kPlace = "in vec3 v_place;\nvec3 colour() { return v_place; }\n";
inline constexpr std::string_view kNormal = "in vec3 v_normal;\nvec3 colour() { return v_normal; }\n";
inline constexpr std::string_view kOwnColour = "in vec3 v_colour;\nvec3 colour() { return v_colour; }\n";
inline constexpr std::string_view kDepth = "vec3 colour() { return vec3(1.0 / gl_FragCoord.w, 0.0, 0.0); }\n";

// Three corners of a triangle that covers the picture.
inline constexpr std::string_view kWholePicture = R"(#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

// What one camera has to say of every pixel: its colour times its weight, and the weight.
inline constexpr std::string_view kAddCamera = R"(#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D u_places, u_normals;  // of the viewpoint: world; w of the first is 1 where the surface is
uniform sampler2D u_picture, u_depths;  // of the camera
uniform mat3 u_rotation, u_k;           // camera from world; pixels from the image plane
uniform vec3 u_translation, u_centre, u_eye;
uniform float u_distortion[5], u_fold;  // k1 k2 p1 p2 k3; squared radius beyond which the lens folds over
uniform float u_focal, u_eye_focal, u_tolerance, u_angle_power;
out vec4 o_sum;

const float kLeastCosine = 0.15;  // 81 degrees
const float kSteepest = 5.0;      // tangent of the slope that a difference in depth is excused by
const float kLeastAngle = 0.02;   // radians: nearer cameras are as good as there
const int kReach = 4;             // pixels from another part's edge where a view counts in full again

vec2 distorted(vec2 p) {
  float r2 = dot(p, p);
  float radial = 1.0 + r2 * (u_distortion[0] + r2 * (u_distortion[1] + r2 * u_distortion[4]));
  return p * radial + vec2(2.0 * u_distortion[2] * p.x * p.y + u_distortion[3] * (r2 + 2.0 * p.x * p.x),
                           u_distortion[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * u_distortion[3] * p.x * p.y);
}

// 0 for a place that something nearer hides, or so near to its edge that pixels mix both; rising with the distance from
// that edge; less than 1 beside a drop to what lies behind. What lies beyond the surface's outline is the matte's to
// judge.
float share_seen(ivec2 size, vec2 pixel, float depth, float footprint, float slope) {
  const ivec2 ways[8] = ivec2[8](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1), ivec2(-1, 0), ivec2(-1, -1),
                                 ivec2(0, -1), ivec2(1, -1));
  ivec2 middle = ivec2(floor(pixel + 0.5));
  middle.y = size.y - 1 - middle.y;
  if (texelFetch(u_depths, middle, 0).r < depth - footprint * (u_tolerance + slope)) return 0.0;
  float clear = 1.0, seen = 1.0, judged = 1.0;
  for (int r = 1; r <= kReach; ++r) {
    float tolerance = footprint * (u_tolerance + 1.5 * float(r) * slope);
    for (int i = 0; i < 8; ++i) {
      float nearest = texelFetch(u_depths, clamp(middle + r * ways[i], ivec2(0), size - 1), 0).r;
      if (nearest < depth - tolerance) clear = min(clear, float(r - 1) / float(kReach));
      if (r <= 2 && nearest < 1e8) {
        judged += 1.0;
        if (nearest <= depth + tolerance) seen += 1.0;
      }
    }
  }
  return clear * seen / judged;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 place = texelFetch(u_places, at, 0);
  if (place.w == 0.0) discard;
  vec3 to_camera = u_centre - place.xyz, to_eye = u_eye - place.xyz;
  vec3 towards = normalize(to_camera);
  float cosine = dot(normalize(texelFetch(u_normals, at, 0).xyz), towards);
  if (!(cosine >= kLeastCosine)) discard;
  vec3 seen_at = u_rotation * place.xyz + u_translation;
  if (seen_at.z <= 0.0) discard;
  vec2 ideal = seen_at.xy / seen_at.z;
  if (dot(ideal, ideal) > u_fold) discard;
  vec2 pixel = (u_k * vec3(distorted(ideal), 1.0)).xy;
  ivec2 size = textureSize(u_picture, 0);
  if (any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, vec2(size - 1)))) discard;
  float finer = (u_focal / length(to_camera)) / (u_eye_focal / length(to_eye));  // than the viewpoint
  vec4 found = textureLod(u_picture, (pixel + 0.5) / vec2(size), log2(max(1.0, finer)));
  if (found.a == 0.0) discard;
  float slope = min(kSteepest, sqrt(max(0.0, 1.0 - cosine * cosine)) / cosine);
  float seen = share_seen(size, pixel, seen_at.z, seen_at.z / u_focal, slope);
  if (seen == 0.0) discard;
  float angle = distance(towards, normalize(to_eye));
  float weight = pow(angle * angle + kLeastAngle * kLeastAngle, -0.5 * u_angle_power) * cosine *
                 min(1.0, finer * finer) * seen * found.a;
  o_sum = weight * vec4(found.rgb, 1.0);
}
)";

// The mean; where hardly any camera counts the surface's own colour comes in.
inline constexpr std::string_view kMix = R"(#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D u_places, u_own, u_sum;
out vec4 o_colour;
const float kOwnWeight = 1e-3;  // a camera that sees the place well counts 0.1 or more
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  if (texelFetch(u_places, at, 0).w == 0.0) discard;
  vec4 sum = texelFetch(u_sum, at, 0);
  o_colour = vec4((sum.rgb + kOwnWeight * texelFetch(u_own, at, 0).rgb) / (sum.a + kOwnWeight), 1.0);
}
)";

}  // namespace rotunda::playback::view_dependent
