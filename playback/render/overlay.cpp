#include "playback/render/overlay.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rotunda::playback {
namespace {

constexpr std::string_view kVertex = R"(#version 300 es
precision highp float;
uniform vec4 u_box;  // left, top, right, bottom on the device
out vec2 v_texel;
void main() {
  v_texel = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(mix(u_box.x, u_box.z, v_texel.x), mix(u_box.y, u_box.w, v_texel.y), 0.0, 1.0);
}
)";

constexpr std::string_view kFragment = R"(#version 300 es
precision highp float;
uniform sampler2D u_picture;
in vec2 v_texel;
out vec4 o_colour;
void main() { o_colour = texture(u_picture, v_texel); }
)";

}  // namespace

Overlay::Overlay() : program_(make_program(kVertex, kFragment)), vertices_(make_vertex_array()) {}

void Overlay::draw(const cv::Mat& rgba, int x, int y, int width, int height) {
  if (rgba.empty() || width < 1 || height < 1) return;
  texture_ = make_picture(rgba);
  glUseProgram(program_.get());
  const auto on_device = [](int pixel, int size) {
    return 2.0F * static_cast<float>(pixel) / static_cast<float>(size) - 1.0F;
  };
  glUniform4f(uniform(program_, "u_box"), on_device(x, width), -on_device(y, height), on_device(x + rgba.cols, width),
              -on_device(y + rgba.rows, height));
  glUniform1i(uniform(program_, "u_picture"), 0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glBindVertexArray(vertices_.get());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisable(GL_BLEND);
}

cv::Mat text_card(const std::vector<std::string>& lines) {
  constexpr int kLine = 20, kMargin = 10;
  constexpr double kSize = 0.5;
  int widest = 0, below = 0;
  for (const auto& line : lines)
    widest = std::max(widest, cv::getTextSize(line, cv::FONT_HERSHEY_SIMPLEX, kSize, 1, &below).width);
  cv::Mat card(static_cast<int>(lines.size()) * kLine + 2 * kMargin, widest + 2 * kMargin, CV_8UC4,
               cv::Scalar(16, 18, 22, 170));
  for (std::size_t i = 0; i < lines.size(); ++i)
    cv::putText(card, lines[i], {kMargin, kMargin + static_cast<int>(i + 1) * kLine - 6}, cv::FONT_HERSHEY_SIMPLEX,
                kSize, cv::Scalar(235, 235, 235, 255), 1, cv::LINE_AA);
  return card;
}

}  // namespace rotunda::playback
