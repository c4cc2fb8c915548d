#include "simulator/studio/scene_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

constexpr std::uint64_t kPlateFrame = std::numeric_limits<std::uint64_t>::max();  // seeds the plate's noise

// The shutter's opening and closing about a time, within the round of an act that does not close smoothly.
std::array<double, 2> shutter_times(const Performance& performance, double seconds, double exposure) {
  const double opens = seconds - 0.5 * exposure, closes = seconds + 0.5 * exposure;
  if (performance.is_cyclic()) return {opens, closes};
  const double round = performance.frames() * kActStep, start = std::floor(seconds / round) * round;
  return {std::max(opens, start), std::min(closes, start + round - 1e-6)};
}

std::vector<std::vector<ArrivingLight>> light_on(const std::vector<recon::TriangleMesh>& surfaces,
                                                 const std::vector<Figure>& figures, const ShadowMaps& maps,
                                                 const Eigen::Vector3f& glow) {
  std::vector<std::vector<ArrivingLight>> light;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const auto& surface = surfaces[i];
    auto& lit = light.emplace_back(surface.positions.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lit.size(), 512), [&](const auto& vertices) {
      for (std::size_t v = vertices.begin(); v < vertices.end(); ++v)
        lit[v] = arriving_light({surface.positions[v], surface.normals[v], figures[i].openness[v]},
                                figures[i].material.empty() ? SurfaceMaterial::cloth : figures[i].material[v],
                                maps.at(surface.positions[v], surface.normals[v]), glow);
    });
  }
  return light;
}

}  // namespace

struct SceneRenderer::Moment {
  double seconds = 0.0;
  std::vector<std::vector<ArrivingLight>> light;  // on each figure's vertices
  ContactShadow shadow;
  std::map<double, LitFigures> by_exposure;
};

SceneRenderer::SceneRenderer(const Performance& performance, std::vector<capture::CameraModel> cameras,
                             SensorOptions sensor, const BackdropOptions& backdrop)
    : performance_(performance),
      cameras_(std::move(cameras)),
      options_(std::move(sensor)),
      figures_(performance_.figures()),
      glow_(backdrop.paint == ScreenPaint::blue ? kWallGlow : kGreenGlow) {
  const auto room = room_around(cameras_, backdrop);
  for (const auto& camera : cameras_) {
    backdrops_.push_back(make_backdrop(camera, room));
    lenses_.push_back(lens_flaws(camera, lenses_.size(), options_));
    look_through(lenses_.back(), backdrops_.back().linear);
    sensors_.emplace_back(cv::Size(camera.width, camera.height), sensors_.size(), options_);
  }
}

SceneRenderer::~SceneRenderer() = default;

SceneRenderer::Moment SceneRenderer::moment_at(double seconds) const {
  const auto surfaces = performance_.surfaces_at(seconds);
  const ShadowMaps maps(surfaces);
  return {seconds, light_on(surfaces, performance_.figures(), maps, glow_), contact_shadow(surfaces, maps), {}};
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
  lay_figures(lenses_[camera], layer, linear, picture.matte);
  picture.deep = sensors_[camera].expose(linear, frame);
  picture.rgb = to_8bit(picture.deep);
  return picture;
}

FigureLayer SceneRenderer::figures_before(std::size_t camera, Moment& moment) const {
  return figures_.draw(cameras_[camera], figures_of(moment, camera), default_supersampling(cameras_[camera].width));
}

ScenePicture SceneRenderer::picture(std::size_t camera, double seconds, std::uint64_t frame) const {
  auto moment = moment_at(seconds);
  return develop(camera, figures_before(camera, moment), moment.shadow, frame);
}

std::vector<ScenePicture> SceneRenderer::pictures(double seconds, std::uint64_t frame) const {
  auto moment = moment_at(seconds);
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) figures_of(moment, camera);
  std::vector<ScenePicture> pictures(cameras_.size());
  tbb::parallel_for(std::size_t{0}, pictures.size(), [&](std::size_t camera) {
    pictures[camera] = develop(camera, figures_before(camera, moment), moment.shadow, frame);
  });
  return pictures;
}

cv::Mat SceneRenderer::clean_plate(std::size_t camera) const {
  return to_8bit(sensors_[camera].expose(backdrops_[camera].linear, kPlateFrame));
}

cv::Mat SceneRenderer::figures_alone(std::size_t camera, double seconds, const Eigen::Vector3f& glow) const {
  const auto surfaces = performance_.surfaces_at(seconds);
  const auto light = light_on(surfaces, performance_.figures(), ShadowMaps(surfaces), glow);
  const auto [opens, closes] = shutter_times(performance_, seconds, settings_of(options_, camera).exposure_s);
  const auto layer =
      figures_.draw(cameras_[camera], {performance_.surfaces_at(opens), performance_.surfaces_at(closes), light},
                    default_supersampling(cameras_[camera].width));
  // Before black and before white: the difference tells each channel's cover, which lateral colour makes its own.
  cv::Mat before_black(backdrops_[camera].linear.size(), CV_32FC3, cv::Scalar::all(0.0)), matte;
  cv::Mat before_white(before_black.size(), CV_32FC3, cv::Scalar::all(1.0));
  matte = cv::Mat::zeros(before_black.size(), CV_8UC1);
  lay_figures(lenses_[camera], {layer.box, layer.rgba.clone()}, before_black, matte);
  lay_figures(lenses_[camera], {layer.box, layer.rgba.clone()}, before_white, matte);
  const cv::Mat cover = cv::Scalar::all(1.0) - (before_white - before_black);
  const cv::Mat own = before_black / cv::max(cover, 1e-3);
  SensorOptions quiet = options_;
  quiet.read_noise = quiet.pixel_spread = quiet.hot_pixels_per_mega = 0.0;
  quiet.full_well *= 1e4;
  return to_8bit(Sensor(own.size(), camera, quiet).expose(own, 0));
}

}  // namespace rotunda::simulator
