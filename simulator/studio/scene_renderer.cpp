#include "simulator/studio/scene_renderer.h"

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

constexpr std::uint64_t kPlateFrame = std::numeric_limits<std::uint64_t>::max();  // seeds the plate's noise

void lay_figures(const FigureLayer& layer, cv::Mat& linear, cv::Mat& matte) {
  for (int y = 0; y < layer.box.height; ++y) {
    auto* pixel = linear.ptr<cv::Vec3f>(layer.box.y + y) + layer.box.x;
    auto* cover = matte.ptr<std::uint8_t>(layer.box.y + y) + layer.box.x;
    const auto* figure = layer.rgba.ptr<cv::Vec4f>(y);
    for (int x = 0; x < layer.box.width; ++x) {
      const float alpha = figure[x][3];
      if (alpha <= 0.0F) continue;
      for (int c = 0; c < 3; ++c) pixel[x][c] = figure[x][c] + pixel[x][c] * (1.0F - alpha);
      cover[x] = static_cast<std::uint8_t>(std::min(alpha, 1.0F) * 255.0F + 0.5F);
    }
  }
}

// The shutter's opening and closing about a time, within the round of an act that does not close smoothly.
std::array<double, 2> shutter_times(const Performance& performance, double seconds, double exposure) {
  const double opens = seconds - 0.5 * exposure, closes = seconds + 0.5 * exposure;
  if (performance.is_cyclic()) return {opens, closes};
  const double round = performance.frames() * kActStep, start = std::floor(seconds / round) * round;
  return {std::max(opens, start), std::min(closes, start + round - 1e-6)};
}

std::vector<std::vector<Eigen::Vector3f>> light_on(const std::vector<recon::TriangleMesh>& surfaces,
                                                   const std::vector<Figure>& figures, const ShadowMaps& maps) {
  std::vector<std::vector<Eigen::Vector3f>> light;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const auto& surface = surfaces[i];
    auto& lit = light.emplace_back(surface.positions.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lit.size(), 512), [&](const auto& vertices) {
      for (std::size_t v = vertices.begin(); v < vertices.end(); ++v)
        lit[v] = irradiance(surface.positions[v], surface.normals[v], figures[i].openness[v],
                            maps.at(surface.positions[v], surface.normals[v]));
    });
  }
  return light;
}

}  // namespace

struct SceneRenderer::Moment {
  double seconds = 0.0;
  std::vector<std::vector<Eigen::Vector3f>> light;  // on each figure's vertices
  ContactShadow shadow;
  std::map<double, LitFigures> by_exposure;
};

SceneRenderer::SceneRenderer(const Performance& performance, std::vector<capture::CameraModel> cameras,
                             SensorOptions sensor)
    : performance_(performance), cameras_(std::move(cameras)), options_(std::move(sensor)) {
  std::map<int, FigureRenderer*> by_supersampling;
  for (const auto& camera : cameras_) {
    backdrops_.push_back(make_backdrop(camera));
    sensors_.emplace_back(cv::Size(camera.width, camera.height), sensors_.size(), options_);
    auto& renderer = by_supersampling[default_supersampling(camera.width)];
    if (!renderer)
      renderer = renderers_
                     .emplace_back(
                         std::make_unique<FigureRenderer>(performance_.figures(), default_supersampling(camera.width)))
                     .get();
    renderer_of_.push_back(renderer);
  }
}

SceneRenderer::~SceneRenderer() = default;

SceneRenderer::Moment SceneRenderer::moment_at(double seconds) const {
  const auto surfaces = performance_.surfaces_at(seconds);
  const ShadowMaps maps(surfaces);
  return {seconds, light_on(surfaces, performance_.figures(), maps), contact_shadow(surfaces, maps), {}};
}

// Cameras that expose as long see the same.
const LitFigures& SceneRenderer::figures_of(Moment& moment, std::size_t camera) const {
  const double exposure = settings_of(options_, camera).exposure_s;
  const auto known = moment.by_exposure.find(exposure);
  if (known != moment.by_exposure.end()) return known->second;
  const auto [opens, closes] = shutter_times(performance_, moment.seconds, exposure);
  return moment.by_exposure
      .emplace(exposure, LitFigures{performance_.surfaces_at(opens), performance_.surfaces_at(closes), moment.light})
      .first->second;
}

ScenePicture SceneRenderer::develop(std::size_t camera, const FigureLayer& layer, const ContactShadow& shadow,
                                    std::uint64_t frame) const {
  cv::Mat linear = backdrops_[camera].linear.clone();
  ScenePicture picture;
  picture.matte = cv::Mat(linear.size(), CV_8UC1, cv::Scalar(0));
  lay_shadow(backdrops_[camera], shadow, linear);
  if (!layer.box.empty() && options_.lens_blur_px > 0.0)
    cv::GaussianBlur(layer.rgba, layer.rgba, {5, 5}, options_.lens_blur_px, 0, cv::BORDER_REPLICATE);
  lay_figures(layer, linear, picture.matte);
  picture.deep = sensors_[camera].expose(linear, frame);
  picture.rgb = to_8bit(picture.deep);
  return picture;
}

ScenePicture SceneRenderer::picture(std::size_t camera, double seconds, std::uint64_t frame) {
  auto moment = moment_at(seconds);
  return develop(camera, renderer_of_[camera]->draw(cameras_[camera], figures_of(moment, camera)), moment.shadow,
                 frame);
}

// This thread draws; what comes after drawing goes on beside it, at most a few pictures behind.
std::vector<ScenePicture> SceneRenderer::pictures(double seconds, std::uint64_t frame) {
  auto moment = moment_at(seconds);
  std::vector<ScenePicture> pictures(cameras_.size());
  tbb::task_group developing;
  constexpr std::size_t kAhead = 8;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    if (camera % kAhead == 0) developing.wait();  // figures are large: not all of 64 cameras' at once
    developing.run([this, &pictures, &moment, camera, frame,
                    layer = renderer_of_[camera]->draw(cameras_[camera], figures_of(moment, camera))] {
      pictures[camera] = develop(camera, layer, moment.shadow, frame);
    });
  }
  developing.wait();
  return pictures;
}

cv::Mat SceneRenderer::clean_plate(std::size_t camera) {
  return to_8bit(sensors_[camera].expose(backdrops_[camera].linear, kPlateFrame));
}

}  // namespace rotunda::simulator
