#include "simulator/studio/scene_renderer.h"

#include <tbb/parallel_for.h>

#include <limits>
#include <map>

namespace rotunda::simulator {
namespace {

constexpr std::uint64_t kPlateFrame = std::numeric_limits<std::uint64_t>::max();  // seeds the plate's noise

void lay_person(const PersonLayer& layer, cv::Mat& linear, cv::Mat& matte) {
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

SceneRenderer::SceneRenderer(Person person, std::vector<capture::CameraModel> cameras, SensorOptions sensor)
    : person_(std::move(person)), cameras_(std::move(cameras)), sensor_(sensor) {
  std::map<int, PersonRenderer*> by_supersampling;
  for (const auto& camera : cameras_) {
    backdrops_.push_back(make_backdrop(camera));
    auto& renderer = by_supersampling[default_supersampling(camera.width)];
    if (!renderer)
      renderer =
          renderers_.emplace_back(std::make_unique<PersonRenderer>(person_, default_supersampling(camera.width))).get();
    renderer_of_.push_back(renderer);
  }
}

SceneRenderer::~SceneRenderer() = default;

ScenePicture SceneRenderer::compose(std::size_t camera, const recon::TriangleMesh& body, const ContactShadow& shadow,
                                    std::uint64_t frame) {
  cv::Mat linear = backdrops_[camera].linear.clone();
  ScenePicture picture;
  picture.matte = cv::Mat(linear.size(), CV_8UC1, cv::Scalar(0));
  lay_shadow(backdrops_[camera], shadow, linear);
  lay_person(renderer_of_[camera]->draw(cameras_[camera], body), linear, picture.matte);
  picture.rgb = expose(linear, camera, frame, sensor_);
  return picture;
}

ScenePicture SceneRenderer::picture(std::size_t camera, const Pose& pose, std::uint64_t frame) {
  const auto body = posed_mesh(person_, pose);
  return compose(camera, body, contact_shadow(body), frame);
}

std::vector<ScenePicture> SceneRenderer::pictures(const Pose& pose, std::uint64_t frame) {
  const auto body = posed_mesh(person_, pose);
  const auto shadow = contact_shadow(body);
  std::vector<ScenePicture> pictures;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    pictures.push_back(compose(camera, body, shadow, frame));
  return pictures;
}

cv::Mat SceneRenderer::clean_plate(std::size_t camera) {
  return expose(backdrops_[camera].linear, camera, kPlateFrame, sensor_);
}

}  // namespace rotunda::simulator
