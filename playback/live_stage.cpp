#include "playback/live_stage.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "playback/display/headless.h"
#include "playback/render/stage.h"

namespace rotunda::playback {
namespace {

constexpr double kFollow_s = 0.5;       // the eye's time constant
constexpr double kMostSideShare = 0.4;  // of the view's width
constexpr int kGap = 4;                 // pixels between pictures

// Of the performer, not of a hand that reaches out: half the box's height, the vertices' middle over the floor.
Eigen::Vector3d middle_of(const recon::TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& position : mesh.positions) sum += position.cast<double>();
  sum /= static_cast<double>(std::max<std::size_t>(1, mesh.positions.size()));
  return {sum.x(), sum.y(), box.center().z()};
}

Eigen::AlignedBox3d box_of(const recon::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& position : mesh.positions) box.extend(position.cast<double>());
  return box;
}

}  // namespace

std::vector<cv::Rect> side_places(const std::vector<cv::Mat>& sides, int width, int height) {
  std::vector<cv::Rect> places;
  const int count = static_cast<int>(sides.size());
  for (int i = 0; i < count; ++i) {
    const auto& side = sides[static_cast<std::size_t>(i)];
    const double room_down = static_cast<double>(height - (count + 1) * kGap) / count;
    const double scale = std::min(room_down / side.rows, kMostSideShare * width / side.cols);
    const int across = std::max(1, static_cast<int>(side.cols * scale)),
              down = std::max(1, static_cast<int>(side.rows * scale));
    places.emplace_back(width - across - kGap, kGap + static_cast<int>(i * (room_down + kGap)), across, down);
  }
  return places;
}

LiveStage::LiveStage() : side_texture_(make_texture()) {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  side_frame_ = GlFramebuffer(name);
}

void LiveStage::show(const LiveView& view) {
  renderer_.upload(view.surface.mesh);
  sides_ = view.sides;
  if (!view.surface.mesh.positions.empty()) follow(view.surface);
}

void LiveStage::follow(const recon::LiveSurface& surface) {
  const auto box = box_of(surface.mesh);
  const auto middle = middle_of(surface.mesh, box);
  if (!shown_) {
    front_ = orbit_around(box);
    front_.target = middle;
    orbit_ = front_;
  }
  const double since = shown_ ? std::chrono::duration<double>(surface.exposure - *shown_).count() : 0.0;
  const double share = since > 0.0 ? 1.0 - std::exp(-since / kFollow_s) : 0.0;
  orbit_.target += share * (middle - orbit_.target);
  shown_ = surface.exposure;
}

void LiveStage::look_from_front() {
  const Eigen::Vector3d target = orbit_.target;
  orbit_ = front_;
  orbit_.target = target;
}

void LiveStage::draw(int width, int height) {
  glViewport(0, 0, width, height);
  clear(kDarkRoom);
  const auto places = side_places(sides_, width, height);
  int room = width;
  for (const auto& place : places) room = std::min(room, place.x - kGap);
  if (shown_ && room > 0) {
    glViewport(0, 0, room, height);
    renderer_.draw(orbit_.viewpoint(room, height), options_);
  }
  for (std::size_t i = 0; i < places.size(); ++i) draw_side(sides_[i], places[i], height);
}

void LiveStage::draw_side(const cv::Mat& rgb, const cv::Rect& place, int height) {
  cv::Mat rgba;
  cv::cvtColor(rgb, rgba, cv::COLOR_RGB2RGBA);
  glBindTexture(GL_TEXTURE_2D, side_texture_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, rgba.cols, rgba.rows, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, side_frame_.get());
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, side_texture_.get(), 0);
  // GL counts rows from below, the picture's first row is its top.
  glBlitFramebuffer(0, 0, rgba.cols, rgba.rows, place.x, height - place.y, place.x + place.width,
                    height - place.y - place.height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

cv::Mat live_picture(const LiveView& view, int width, int height) {
  const HeadlessDisplay display;
  const RenderTarget target(width, height);
  LiveStage stage;
  stage.show(view);
  target.bind();
  stage.draw(width, height);
  cv::Mat rgb;
  cv::cvtColor(target.read_rgba(), rgb, cv::COLOR_RGBA2RGB);
  return rgb;
}

}  // namespace rotunda::playback
