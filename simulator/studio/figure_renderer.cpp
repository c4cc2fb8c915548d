#include "simulator/studio/figure_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

constexpr auto kVertexShader = R"(#version 300 es
layout(location = 0) in vec4 clip;
layout(location = 1) in vec4 light;  // rgb: what falls on the surface; a: grazing reflection
layout(location = 2) in vec2 corner;
out vec4 light_here;
out vec2 texel;
void main() {
  gl_Position = clip;
  light_here = light;
  texel = corner;
})";

// The texture is sRGB: sampling it gives linear reflectance. The target holds sRGB values for their finer dark steps.
constexpr auto kFragmentShader = R"(#version 300 es
precision highp float;
uniform sampler2D cloth;
uniform vec3 wall_glow;
in vec4 light_here;
in vec2 texel;
out vec4 colour;
void main() {
  vec3 linear = texture(cloth, texel).rgb * light_here.rgb + light_here.a * wall_glow;
  linear = clamp(linear, 0.0, 1.0);
  vec3 high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  colour = vec4(mix(high, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1.0);
})";

struct DrawnVertex {
  std::array<float, 4> clip, light;
};

struct SeenVertex {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double depth = 0.0;  // metres along the axis; 0: not in sight
  std::array<float, 4> light{};
};

SeenVertex see(const capture::CameraModel& camera, const Vector3f& position, const Vector3f& normal, float openness) {
  SeenVertex seen;
  const auto pixel = capture::project(camera, position.cast<double>());
  if (!pixel) return seen;
  seen.pixel = *pixel;
  seen.depth = camera.R.row(2).dot(position.cast<double>()) + camera.t.z();
  const Vector3f light = irradiance(position, normal, openness);
  const Vector3f to_eye = (camera.centre().cast<float>() - position).normalized();
  seen.light = {light.x(), light.y(), light.z(), grazing_reflection(normal, to_eye) * openness};
  return seen;
}

std::vector<SeenVertex> see_all(const capture::CameraModel& camera, const recon::TriangleMesh& surface,
                                const std::vector<float>& openness) {
  std::vector<SeenVertex> seen(surface.positions.size());
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t v) {
    seen[v] = see(camera, surface.positions[v], surface.normals[v], openness[v]);
  });
  return seen;
}

cv::Rect box_of(const std::vector<std::vector<SeenVertex>>& seen, const capture::CameraModel& camera) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (const auto& figure : seen)
    for (const auto& vertex : figure) {
      if (vertex.depth <= 0.0) continue;
      low = low.min(vertex.pixel.array());
      high = high.max(vertex.pixel.array());
    }
  low = (low - 1.0).floor().max(0.0);
  high = (high + 2.0).ceil().min(Eigen::Array2d(camera.width, camera.height));
  if ((low >= high).any()) return {};
  return {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x() - low.x()),
          static_cast<int>(high.y() - low.y())};
}

// Clip coordinates in which the box fills the viewport, its top row first in memory.
std::array<float, 4> clip_of(const SeenVertex& seen, const cv::Rect& box) {
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

std::vector<DrawnVertex> corners_to_draw(const std::vector<SeenVertex>& seen, const recon::TriangleMesh& surface,
                                         const cv::Rect& box) {
  std::vector<DrawnVertex> drawn(3 * surface.triangles.size());
  tbb::parallel_for(std::size_t{0}, surface.triangles.size(), [&](std::size_t t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& vertex = seen[surface.triangles[t][i]];
      drawn[3 * t + i] = {clip_of(vertex, box), vertex.light};
    }
  });
  return drawn;
}

const std::array<float, 256>& linear_of_srgb() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      values[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table;
}

// Mean over the samples of each pixel, in linear light.
void filter_down(const cv::Mat& samples, int factor, FigureLayer& layer) {
  const auto& linear = linear_of_srgb();
  const float share = 1.0F / static_cast<float>(factor * factor);
  tbb::parallel_for(0, layer.box.height, [&](int y) {
    auto* colour = layer.premultiplied.ptr<cv::Vec3f>(y);
    auto* alpha = layer.alpha.ptr<float>(y);
    for (int x = 0; x < layer.box.width; ++x) {
      cv::Vec3f sum(0.0F, 0.0F, 0.0F);
      int covered = 0;
      for (int j = 0; j < factor; ++j) {
        const auto* sample = samples.ptr<cv::Vec4b>(y * factor + j) + x * factor;
        for (int i = 0; i < factor; ++i) {
          if (sample[i][3] == 0) continue;
          ++covered;
          for (int c = 0; c < 3; ++c) sum[c] += linear[sample[i][c]];
        }
      }
      colour[x] = sum * share;
      alpha[x] = static_cast<float>(covered) * share;
    }
  });
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
    : figures_(figures),
      supersampling_(supersampling),
      program_(playback::make_program(kVertexShader, kFragmentShader)) {
  for (const auto& figure : figures) drawn_.push_back(upload(figure));
}

FigureRenderer::DrawnFigure FigureRenderer::upload(const Figure& figure) {
  const cv::Mat& picture = figure.texture.picture;
  DrawnFigure drawn{upload_picture(picture), playback::make_buffer(), playback::make_buffer(),
                    playback::make_vertex_array()};
  std::vector<Eigen::Vector2f> corners = figure.texture.corners;
  const Eigen::Array2f size(static_cast<float>(picture.cols), static_cast<float>(picture.rows));
  for (auto& corner : corners) corner = (corner.array() / size).matrix();
  glBindVertexArray(drawn.array.get());
  glBindBuffer(GL_ARRAY_BUFFER, drawn.corners.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(corners[0])), corners.data(),
               GL_STATIC_DRAW);
  glVertexAttribPointer(2, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  glBindBuffer(GL_ARRAY_BUFFER, drawn.vertices.get());
  const auto* offset = reinterpret_cast<const void*>(offsetof(DrawnVertex, light));
  glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(DrawnVertex), nullptr);
  glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(DrawnVertex), offset);
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
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

FigureLayer FigureRenderer::draw(const capture::CameraModel& camera, const std::vector<recon::TriangleMesh>& surfaces) {
  std::vector<std::vector<SeenVertex>> seen;
  for (std::size_t i = 0; i < surfaces.size(); ++i) seen.push_back(see_all(camera, surfaces[i], figures_[i].openness));
  FigureLayer layer;
  layer.box = box_of(seen, camera);
  if (layer.box.empty()) return layer;
  const cv::Size size = layer.box.size() * supersampling_;
  target_for(size).bind();
  glViewport(0, 0, size.width, size.height);
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);  // a renderer that shares the context may have left it on
  glUseProgram(program_.get());
  glUniform3fv(playback::uniform(program_, "wall_glow"), 1, kWallGlow.data());
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const auto vertices = corners_to_draw(seen[i], surfaces[i], layer.box);
    glBindTexture(GL_TEXTURE_2D, drawn_[i].texture.get());
    glBindVertexArray(drawn_[i].array.get());
    glBindBuffer(GL_ARRAY_BUFFER, drawn_[i].vertices.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(DrawnVertex)), vertices.data(),
                 GL_STREAM_DRAW);
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
  }
  cv::Mat samples(size, CV_8UC4);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE, samples.data);
  layer.premultiplied.create(layer.box.size(), CV_32FC3);
  layer.alpha.create(layer.box.size(), CV_32FC1);
  filter_down(samples, supersampling_, layer);
  return layer;
}

}  // namespace rotunda::simulator
