#include "simulator/studio/scene_renderer.h"

#include <tbb/parallel_for.h>

#include <limits>
#include <map>

namespace rotunda::simulator {
namespace {

constexpr std::uint64_t kPlateFrame = std::numeric_limits<std::uint64_t>::max();  // seeds the plate's noise

void lay_figures(const FigureLayer& layer, cv::Mat& linear, cv::Mat& matte) {
  for (int y = 0; y < layer.box.height; ++y) {
    auto* pixel = linear.ptr<cv::Vec3f>(layer.box.y + y) + layer.box.x;
    auto* cover = matte.ptr<std::uint8_t>(layer.box.y + y) + layer.box.x;
    const auto* colour = layer.premultiplied.ptr<cv::Vec3f>(y);
    const auto* alpha = layer.alpha.ptr<float>(y);
    for (int x = 0; x < layer.box.width; ++x) {
      pixel[x] = colour[x] + pixel[x] * (1.0F - alpha[x]);
      cover[x] = cv::saturate_cast<std::uint8_t>(alpha[x] * 255.0F);
    }
  }
}

}  // namespace

SceneRenderer::SceneRenderer(const Performance& performance, std::vector<capture::CameraModel> cameras,
                             SensorOptions sensor)
    : performance_(performance), cameras_(std::move(cameras)), sensor_(sensor) {
  std::map<int, FigureRenderer*> by_supersampling;
  for (const auto& camera : cameras_) {
    backdrops_.push_back(make_backdrop(camera));
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

ScenePicture SceneRenderer::compose(std::size_t camera, const std::vector<recon::TriangleMesh>& surfaces,
                                    const ContactShadow& shadow, std::uint64_t frame) {
  cv::Mat linear = backdrops_[camera].linear.clone();
  ScenePicture picture;
  picture.matte = cv::Mat(linear.size(), CV_8UC1, cv::Scalar(0));
  lay_shadow(backdrops_[camera], shadow, linear);
  lay_figures(renderer_of_[camera]->draw(cameras_[camera], surfaces), linear, picture.matte);
  picture.rgb = expose(linear, camera, frame, sensor_);
  return picture;
}

ScenePicture SceneRenderer::picture(std::size_t camera, double seconds, std::uint64_t frame) {
  const auto surfaces = performance_.surfaces_at(seconds);
  return compose(camera, surfaces, contact_shadow(surfaces), frame);
}

std::vector<ScenePicture> SceneRenderer::pictures(double seconds, std::uint64_t frame) {
  const auto surfaces = performance_.surfaces_at(seconds);
  const auto shadow = contact_shadow(surfaces);
  std::vector<ScenePicture> pictures;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    pictures.push_back(compose(camera, surfaces, shadow, frame));
  return pictures;
}

cv::Mat SceneRenderer::clean_plate(std::size_t camera) {
  return expose(backdrops_[camera].linear, camera, kPlateFrame, sensor_);
}

}  // namespace rotunda::simulator
