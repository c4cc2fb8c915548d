#include "playback/render/marker_labels.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "playback/render/view_program.h"
#include "playback/surface_pick.h"

namespace rotunda::playback {
namespace {

// Each label is painted into its cell of one picture.
constexpr int kCellWidth = 48, kCellHeight = 22, kColumns = 16;
constexpr int kDotX = 10, kDotY = 11;  // the dot's middle in the cell
constexpr int kDotWidth = 18;          // of a cell: what is left of the text
constexpr double kTextSize = 0.35;
// Metres towards the eye, so that the surface about a dot does not cut it; text before the dots beside it.
constexpr float kInFront = 0.02F, kTextInFront = 0.05F;

constexpr std::string_view kVertex = R"(#version 300 es
precision highp float;
layout(location = 0) in vec3 a_place;
layout(location = 1) in vec2 a_shown;  // how much of the cell's width, 0: nothing; how far towards the eye, metres
uniform mat4 u_clip_from_world;
uniform vec3 u_eye;
uniform vec2 u_size;      // of the picture, pixels
uniform vec4 u_cell;      // width, height of a cell; the dot in it
uniform float u_columns, u_rows;
out vec2 v_texel;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * vec2(a_shown.x, 1.0);
  vec2 cell = vec2(mod(float(gl_InstanceID), u_columns), floor(float(gl_InstanceID) / u_columns));
  v_texel = (cell + corner) / vec2(u_columns, u_rows);
  vec3 to_eye = u_eye - a_place;
  vec4 clip = u_clip_from_world * vec4(a_place + a_shown.y * normalize(to_eye), 1.0);
  vec2 middle = (clip.xy / clip.w + 1.0) * 0.5 * u_size;  // rounded, so that text is drawn pixel for pixel
  vec2 pixel = floor(middle) + (corner * u_cell.xy - u_cell.zw) * vec2(1.0, -1.0);
  float depth = max(clip.z, -clip.w);  // not nearer than what is drawn at all
  gl_Position = vec4((pixel / u_size * 2.0 - 1.0) * clip.w, depth, clip.w);
}
)";

constexpr std::string_view kFragment = R"(#version 300 es
precision highp float;
uniform sampler2D u_cells;
in vec2 v_texel;
out vec4 o_colour;
void main() {
  o_colour = texture(u_cells, v_texel);
  if (o_colour.a < 0.5) discard;  // depth is written: dots in front hide those behind
}
)";

void paint(cv::Mat cell, const MarkerLabel& label) {
  const cv::Point middle(kDotX, kDotY);
  const cv::Scalar dark(12, 12, 14, 255), light(255, 255, 255, 255),
      own(label.colour[0], label.colour[1], label.colour[2], 255);
  if (label.selected || label.goes_along) cv::circle(cell, middle, label.selected ? 9 : 7, light, cv::FILLED);
  cv::circle(cell, middle, label.selected ? 7 : 5, dark, cv::FILLED);
  cv::circle(cell, middle, label.selected ? 6 : 4, own, cv::FILLED);
  const cv::Point text(kDotX + (label.selected ? 11 : 9), kDotY + 4);
  cv::putText(cell, label.text, text, cv::FONT_HERSHEY_SIMPLEX, kTextSize, dark, 3);
  cv::putText(cell, label.text, text, cv::FONT_HERSHEY_SIMPLEX, kTextSize,
              label.selected ? cv::Scalar(255, 235, 60, 255) : light, 1);
}

template <class T>
void upload(GLuint location, const GlBuffer& buffer, const std::vector<T>& items) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(items.size() * sizeof(T)), items.data(), GL_DYNAMIC_DRAW);
  glVertexAttribPointer(location, sizeof(T) / sizeof(float), GL_FLOAT, GL_FALSE, 0, nullptr);
  glVertexAttribDivisor(location, 1);
  glEnableVertexAttribArray(location);
}

int rows_for(std::size_t count) {
  return std::max(1, (static_cast<int>(count) + kColumns - 1) / kColumns);
}

bool faces(const MarkerLabel& label, const Viewpoint& viewpoint) {
  return label.normal.cast<double>().dot(viewpoint.eye() - label.place.cast<double>()) > 0.0;
}

// Where the label's cell is seen, pixels; nothing on the side of the body that is turned away.
std::optional<cv::Rect> seen_cell(const MarkerLabel& label, const Viewpoint& viewpoint) {
  if (!faces(label, viewpoint)) return std::nullopt;
  const auto seen = seen_at(viewpoint, label.place.cast<double>());
  if (!seen) return std::nullopt;
  int below = 0;
  const int text = cv::getTextSize(label.text, cv::FONT_HERSHEY_SIMPLEX, kTextSize, 1, &below).width;
  return cv::Rect(static_cast<int>(seen->x()) - kDotX, static_cast<int>(seen->y()) - kDotY / 2, kDotX + 11 + text,
                  kCellHeight / 2);
}

}  // namespace

std::vector<bool> with_text(std::span<const MarkerLabel> labels, const Viewpoint& viewpoint) {
  std::vector<bool> with(labels.size(), false);
  std::vector<cv::Rect> taken;
  const auto take = [&](std::size_t i) {
    const auto cell = seen_cell(labels[i], viewpoint);
    if (!cell) return;
    with[i] = std::none_of(taken.begin(), taken.end(), [&](const cv::Rect& other) { return !(other & *cell).empty(); });
    if (with[i]) taken.push_back(*cell);
  };
  const auto matters = [](const MarkerLabel& label) { return label.selected || label.goes_along; };
  for (const bool first : {true, false})
    for (std::size_t i = 0; i < labels.size(); ++i)
      if (matters(labels[i]) == first) take(i);
  return with;
}

MarkerLabels::MarkerLabels()
    : program_(make_program(kVertex, kFragment)),
      vertices_(make_vertex_array()),
      places_(make_buffer()),
      shown_(make_buffer()) {}

void MarkerLabels::paint_cells() {
  cv::Mat cells(rows_for(labels_.size()) * kCellHeight, kColumns * kCellWidth, CV_8UC4, cv::Scalar(0, 0, 0, 0));
  int i = 0;
  for (const auto& label : labels_) {
    paint(cells(cv::Rect(i % kColumns * kCellWidth, i / kColumns * kCellHeight, kCellWidth, kCellHeight)), label);
    ++i;
  }
  cells_ = make_picture(cells);
}

// Painting text costs more than all else: it is done when labels look otherwise, not when they move.
void MarkerLabels::set(std::vector<MarkerLabel> labels) {
  const bool alike = std::equal(labels.begin(), labels.end(), labels_.begin(), labels_.end(),
                                [](const auto& a, const auto& b) { return a.looks_like(b); });
  labels_ = std::move(labels);
  if (labels_.empty()) return;
  if (!alike) paint_cells();
  std::vector<Eigen::Vector3f> places;
  for (const auto& label : labels_) places.push_back(label.place);
  glBindVertexArray(vertices_.get());
  upload(0, places_, places);
}

void MarkerLabels::draw(const Viewpoint& viewpoint, const DepthRange& range) {
  if (labels_.empty()) return;
  std::vector<Eigen::Vector2f> shown;
  for (const bool text : with_text(labels_, viewpoint)) {
    const auto& label = labels_[shown.size()];
    const float dot = faces(label, viewpoint) ? static_cast<float>(kDotWidth) / kCellWidth : 0.0F;
    shown.emplace_back(text ? 1.0F : dot, text || label.goes_along ? kTextInFront : kInFront);
  }
  glBindVertexArray(vertices_.get());
  upload(1, shown_, shown);
  glUseProgram(program_.get());
  const Eigen::Matrix4f clip = clip_from_world(viewpoint, range);
  const Eigen::Vector3f eye = viewpoint.eye().cast<float>();
  glUniformMatrix4fv(uniform(program_, "u_clip_from_world"), 1, GL_FALSE, clip.data());
  glUniform3fv(uniform(program_, "u_eye"), 1, eye.data());
  glUniform2f(uniform(program_, "u_size"), static_cast<float>(viewpoint.width), static_cast<float>(viewpoint.height));
  glUniform4f(uniform(program_, "u_cell"), kCellWidth, kCellHeight, kDotX, kDotY);
  glUniform1f(uniform(program_, "u_columns"), kColumns);
  glUniform1f(uniform(program_, "u_rows"), static_cast<float>(rows_for(labels_.size())));
  glUniform1i(uniform(program_, "u_cells"), 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, cells_.get());
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glBindVertexArray(vertices_.get());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(labels_.size()));
}

}  // namespace rotunda::playback
