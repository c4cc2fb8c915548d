#include "simulator/studio/figure_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <span>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr auto kVertexShader = R"(#version 300 es
layout(location = 0) in vec4 opening;  // clip coordinates when the shutter opens
layout(location = 1) in vec4 closing;  // and closes
layout(location = 2) in vec4 light;    // rgb: what falls on the surface; a: grazing reflection
layout(location = 3) in vec2 corner;
uniform float moment;  // 0 opening, 1 closing
uniform vec2 shift;    // of the sampling grid, clip units
out vec4 light_here;
out vec2 texel;
void main() {
  gl_Position = mix(opening, closing, moment);
  gl_Position.xy += shift * gl_Position.w;
  light_here = light;
  texel = corner;
})";

// The texture is sRGB: sampling it gives linear reflectance. The target holds square roots for their finer dark steps.
constexpr auto kFragmentShader = R"(#version 300 es
precision highp float;
uniform sampler2D cloth;
uniform vec3 wall_glow;
in vec4 light_here;
in vec2 texel;
out vec4 colour;
void main() {
  vec3 linear = texture(cloth, texel).rgb * light_here.rgb + light_here.a * wall_glow;
  colour = vec4(sqrt(clamp(linear, 0.0, 1.0)), 1.0);
})";

struct DrawnVertex {
  std::array<float, 4> opening, closing, light;
  Eigen::Vector2f corner;
};

struct SeenPoint {
  Vector2d pixel = Vector2d::Zero();
  double depth = 0.0;  // metres along the axis; 0: not in sight
};

// A figure through one camera, one a vertex.
struct SeenFigure {
  std::vector<SeenPoint> opening, closing;
  std::vector<std::array<float, 4>> light;
};

SeenPoint see(const capture::CameraModel& camera, const Vector3f& position) {
  const Eigen::Vector3d point = position.cast<double>();
  const auto pixel = capture::project(camera, point);
  if (!pixel) return {};
  return {*pixel, camera.R.row(2).dot(point) + camera.t.z()};
}

SeenFigure see_figure(const capture::CameraModel& camera, const recon::TriangleMesh& opening,
                      const recon::TriangleMesh& closing, const std::vector<Vector3f>& light) {
  const Vector3f eye = camera.centre().cast<float>();
  const std::size_t count = opening.positions.size();
  SeenFigure seen{std::vector<SeenPoint>(count), std::vector<SeenPoint>(count),
                  std::vector<std::array<float, 4>>(count)};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 512), [&](const auto& vertices) {
    for (std::size_t v = vertices.begin(); v < vertices.end(); ++v) {
      const Vector3f& p = opening.positions[v];
      seen.opening[v] = see(camera, p);
      seen.closing[v] = closing.positions[v] == p ? seen.opening[v] : see(camera, closing.positions[v]);
      const float grazing = grazing_reflection(opening.normals[v], (eye - p).normalized());
      const float around = std::min(1.0F, 4.0F * light[v].z());  // where no light comes, none is reflected
      seen.light[v] = {light[v].x(), light[v].y(), light[v].z(), grazing * around};
    }
  });
  return seen;
}

// Room for the lens's blur around them.
cv::Rect box_of(const std::vector<SeenFigure>& seen, const capture::CameraModel& camera) {
  constexpr double kMargin = 3.0;
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (const auto& figure : seen)
    for (const auto* points : {&figure.opening, &figure.closing})
      for (const auto& point : *points) {
        if (point.depth <= 0.0) continue;
        low = low.min(point.pixel.array());
        high = high.max(point.pixel.array());
      }
  low = (low - kMargin).floor().max(0.0);
  high = (high + kMargin + 1.0).ceil().min(Eigen::Array2d(camera.width, camera.height));
  if ((low >= high).any()) return {};
  return {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x() - low.x()),
          static_cast<int>(high.y() - low.y())};
}

double longest_way(const std::vector<SeenFigure>& seen) {  // of a vertex while the shutter is open, pixels
  double longest = 0.0;
  for (const auto& figure : seen)
    for (std::size_t v = 0; v < figure.opening.size(); ++v)
      longest = std::max(longest, (figure.closing[v].pixel - figure.opening[v].pixel).squaredNorm());
  return std::sqrt(longest);
}

// Clip coordinates in which the box fills the viewport, its top row first in memory.
std::array<float, 4> clip_of(const SeenPoint& seen, const cv::Rect& box) {
  constexpr double kNear = 0.2, kFar = 50.0;
  if (seen.depth <= kNear) {
    const float nowhere = std::numeric_limits<float>::quiet_NaN();
    return {nowhere, nowhere, nowhere, nowhere};
  }
  const double w = seen.depth;
  const double x = 2.0 * (seen.pixel.x() + 0.5 - box.x) / box.width - 1.0;
  const double y = 2.0 * (seen.pixel.y() + 0.5 - box.y) / box.height - 1.0;
  const double z = (kFar + kNear) / (kFar - kNear) - 2.0 * kFar * kNear / ((kFar - kNear) * w);
  return {static_cast<float>(x * w), static_cast<float>(y * w), static_cast<float>(z * w), static_cast<float>(w)};
}

// y runs down in pictures: a triangle seen from outside has a negative area there.
bool is_turned_away(const std::vector<SeenPoint>& seen, const std::array<std::uint32_t, 3>& t) {
  const Vector2d u = seen[t[1]].pixel - seen[t[0]].pixel, v = seen[t[2]].pixel - seen[t[0]].pixel;
  return u.x() * v.y() - u.y() * v.x() >= 0.0;
}

std::vector<DrawnVertex> corners_to_draw(const SeenFigure& seen, const recon::TriangleMesh& surface,
                                         const cv::Rect& box, std::span<const Eigen::Vector2f> corners,
                                         bool is_closed) {
  std::vector<std::array<float, 4>> opening(seen.opening.size()), closing(seen.opening.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, opening.size(), 1024), [&](const auto& vertices) {
    for (std::size_t v = vertices.begin(); v < vertices.end(); ++v) {
      opening[v] = clip_of(seen.opening[v], box);
      closing[v] = clip_of(seen.closing[v], box);
    }
  });
  std::vector<DrawnVertex> drawn;
  drawn.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& triangle = surface.triangles[t];
    if (is_closed && is_turned_away(seen.opening, triangle) && is_turned_away(seen.closing, triangle)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t v = triangle[i];
      drawn.push_back({opening[v], closing[v], seen.light[v], corners[3 * t + i]});
    }
  }
  return drawn;
}

// One drawing of the figures: a moment of the exposure, a place of the sampling grid, a part of the target.
struct Pass {
  float moment;    // 0 opening, 1 closing
  Vector2d shift;  // of the figures, pixels
  cv::Point tile;  // its upper left corner, samples
};

struct Passes {
  int factor = 1;  // samples a pixel along each axis, of each pass
  cv::Size size;   // of the target, samples
  std::vector<Pass> all;
};

// As many moments as the fastest vertex goes 1.3 pixels in, and so many samples each that their number stays.
Passes passes_for(double way_px, int supersampling, cv::Size box) {
  int count = 1;
  while (count < 8 && way_px > (count == 1 ? 0.2 : 1.3 * count)) count *= 2;
  Passes passes;
  passes.factor = std::max(1, static_cast<int>(std::lround(supersampling / std::sqrt(count))));
  const int across = count <= 2 ? count : count / 2, down = count / across;
  const cv::Size tile = box * passes.factor;
  passes.size = {tile.width * across, tile.height * down};
  constexpr std::array<int, 8> kReversed{0, 4, 2, 6, 1, 5, 3, 7};  // bits: moments and rows have nothing in common
  for (int k = 0; k < count; ++k) {
    const double column = (k + 0.5) / count - 0.5;
    const double row = (kReversed[static_cast<std::size_t>(k)] * count / 8 + 0.5) / count - 0.5;
    const double moment = ((k * 3) % count + 0.5) / count;
    passes.all.push_back({static_cast<float>(moment),
                          Vector2d(column, row) / passes.factor,
                          {k % across * tile.width, k / across * tile.height}});
  }
  return passes;
}

// Mean over the samples of each pixel, in linear light.
void filter_down(const cv::Mat& samples, const Passes& passes, FigureLayer& layer) {
  const int factor = passes.factor;
  const float share = 1.0F / static_cast<float>(static_cast<std::size_t>(factor * factor) * passes.all.size());
  const float light = share / (255.0F * 255.0F);
  tbb::parallel_for(tbb::blocked_range<int>(0, layer.box.height, 8), [&](const auto& rows) {
    const std::size_t across = static_cast<std::size_t>(layer.box.width);
    std::vector<std::array<std::uint32_t, 4>> sums(across);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      std::fill(sums.begin(), sums.end(), std::array<std::uint32_t, 4>{});
      for (const Pass& pass : passes.all)
        for (int j = 0; j < factor; ++j) {
          const auto* sample = samples.ptr<std::uint8_t>(pass.tile.y + y * factor + j) + 4 * pass.tile.x;
          for (std::size_t x = 0; x < across; ++x)
            for (int i = 0; i < factor; ++i, sample += 4)
              for (std::size_t c = 0; c < 4; ++c) sums[x][c] += std::uint32_t{sample[c]} * sample[c];
        }
      auto* out = layer.rgba.ptr<cv::Vec4f>(y);
      for (std::size_t x = 0; x < across; ++x)
        for (std::size_t c = 0; c < 4; ++c) out[x][static_cast<int>(c)] = light * static_cast<float>(sums[x][c]);
    }
  });
}

// Every edge has its opposite, as on the outside of a solid.
bool is_outside_of_solid(const recon::TriangleMesh& mesh) {
  std::vector<std::array<std::uint32_t, 2>> edges, opposite;
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      edges.push_back({t[i], t[(i + 1) % 3]});
      opposite.push_back({t[(i + 1) % 3], t[i]});
    }
    volume += static_cast<double>(mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])));
  }
  std::sort(edges.begin(), edges.end());
  std::sort(opposite.begin(), opposite.end());
  return volume > 0.0 && edges == opposite;
}

playback::GlTexture upload_picture(const cv::Mat& picture) {
  auto texture = playback::make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, picture.cols, picture.rows, 0, GL_RGB, GL_UNSIGNED_BYTE, picture.data);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  return texture;
}

}  // namespace

int default_supersampling(int picture_width) {
  return std::clamp((2800 + picture_width / 2) / picture_width, 2, 8);
}

FigureRenderer::FigureRenderer(const std::vector<Figure>& figures, int supersampling)
    : supersampling_(supersampling),
      program_(playback::make_program(kVertexShader, kFragmentShader)),
      vertices_(playback::make_buffer()),
      array_(playback::make_vertex_array()) {
  for (const auto& figure : figures) drawn_.push_back(upload(figure));
  glBindVertexArray(array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.get());
  const auto attribute = [](GLuint location, GLint size, std::size_t offset) {
    glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(DrawnVertex),
                          reinterpret_cast<const void*>(offset));
    glEnableVertexAttribArray(location);
  };
  attribute(0, 4, offsetof(DrawnVertex, opening));
  attribute(1, 4, offsetof(DrawnVertex, closing));
  attribute(2, 4, offsetof(DrawnVertex, light));
  attribute(3, 2, offsetof(DrawnVertex, corner));
}

FigureRenderer::DrawnFigure FigureRenderer::upload(const Figure& figure) {
  const cv::Mat& picture = figure.texture.picture;
  DrawnFigure drawn{upload_picture(picture), figure.texture.corners, is_outside_of_solid(figure.bind)};
  const Eigen::Array2f size(static_cast<float>(picture.cols), static_cast<float>(picture.rows));
  for (auto& corner : drawn.corners) corner = (corner.array() / size).matrix();
  return drawn;
}

const playback::RenderTarget& FigureRenderer::target_for(cv::Size size) {
  if (!target_ || target_->width() < size.width || target_->height() < size.height) {
    const int width = std::max(size.width, target_ ? target_->width() : 0);
    const int height = std::max(size.height, target_ ? target_->height() : 0);
    target_.reset();
    target_.emplace(width, height);
  }
  return *target_;
}

FigureLayer FigureRenderer::draw(const capture::CameraModel& camera, const LitFigures& figures) {
  std::vector<SeenFigure> seen;
  for (std::size_t i = 0; i < figures.opening.size(); ++i)
    seen.push_back(see_figure(camera, figures.opening[i], figures.closing[i], figures.light[i]));
  FigureLayer layer;
  layer.box = box_of(seen, camera);
  if (layer.box.empty()) return layer;
  const auto passes = passes_for(longest_way(seen), supersampling_, layer.box.size());
  const cv::Size tile = layer.box.size() * passes.factor;
  target_for(passes.size).bind();
  glDisable(GL_SCISSOR_TEST);
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);  // a renderer that shares the context may have left it on
  glUseProgram(program_.get());
  glUniform3fv(playback::uniform(program_, "wall_glow"), 1, kWallGlow.data());
  const GLint moment = playback::uniform(program_, "moment"), shift = playback::uniform(program_, "shift");
  glBindVertexArray(array_.get());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto vertices =
        corners_to_draw(seen[i], figures.opening[i], layer.box, drawn_[i].corners, drawn_[i].is_closed);
    glBindTexture(GL_TEXTURE_2D, drawn_[i].texture.get());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(DrawnVertex)), vertices.data(),
                 GL_STREAM_DRAW);
    for (const Pass& pass : passes.all) {
      glViewport(pass.tile.x, pass.tile.y, tile.width, tile.height);
      glScissor(pass.tile.x, pass.tile.y, tile.width, tile.height);
      glUniform1f(moment, pass.moment);
      glUniform2f(shift, static_cast<float>(2.0 * pass.shift.x() / layer.box.width),
                  static_cast<float>(2.0 * pass.shift.y() / layer.box.height));
      glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
    }
  }
  glDisable(GL_SCISSOR_TEST);
  cv::Mat samples(passes.size, CV_8UC4);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, samples.cols, samples.rows, GL_RGBA, GL_UNSIGNED_BYTE, samples.data);
  layer.rgba.create(layer.box.size(), CV_32FC4);
  filter_down(samples, passes, layer);
  return layer;
}

}  // namespace rotunda::simulator
