#include "tests/bench/surface_study.h"

#include <fmt/format.h>

#include <optional>

#include "capture/matte/chroma_key.h"
#include "capture/matte/stage_mask.h"
#include "capture/picture.h"
#include "recon/hull/matte_support.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/people/person.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"
#include "tests/bench/own_calibration.h"

namespace rotunda::bench {
namespace {

namespace fs = std::filesystem;
using capture::PixelFormat;

cv::Mat as_received(const cv::Mat& deep) {
  return capture::to_rgb(capture::make_image(deep.cols, deep.rows, PixelFormat::bayer_rg8,
                                             simulator::encode_pixels(deep, PixelFormat::bayer_rg8)));
}

// The study's person and room, made when something is asked of them that is not kept.
class MomentSource {
 public:
  MomentSource(const SurfaceStudy& study, const fs::path& keep)
      : study_(study), folder_(keep.empty() ? fs::path() : keep / study.name()) {
    if (!folder_.empty()) fs::create_directories(folder_);
    if (study.own_calibration) own_cameras_ = own_calibration(study.rig, study.cameras, keep);
  }

  SurfaceMoment moment(int frame) {
    SurfaceMoment moment{.name = fmt::format("{}-{:03}", study_.name(), frame), .cameras = study_.cameras};
    std::vector<simulator::ScenePicture> pictures;
    const auto picture = [&](std::size_t i) -> const simulator::ScenePicture& {
      if (pictures.empty())
        pictures = studio().pictures(simulator::act_seconds(frame), static_cast<std::uint64_t>(frame));
      return pictures[i];
    };
    for (std::size_t i = 0; i < study_.cameras.size(); ++i) {
      moment.pictures.push_back(get(name("picture", frame, i), 3, [&] { return as_received(picture(i).deep); }));
      moment.truth.push_back({get(name("truth", frame, i), 1, [&] { return picture(i).matte; })});
    }
    moment.mattes = keyed("key", moment.pictures, frame, study_.cameras);
    if (study_.own_calibration) {
      moment.own_cameras = own_cameras_;
      moment.own_mattes = keyed("own-key", moment.pictures, frame, own_cameras_);
    }
    moment.body = body(frame);
    return moment;
  }

 private:
  static std::string name(const char* what, int frame, std::size_t camera) {
    return fmt::format("{}{:04}-{:02}", what, frame, camera);
  }

  template <class Make>
  cv::Mat get(const std::string& name, int channels, Make&& make) const {
    const auto file = folder_ / (name + ".png");
    if (!folder_.empty() && fs::exists(file)) return channels == 1 ? capture::read_grey(file) : capture::read_rgb(file);
    const cv::Mat picture = make();
    if (!folder_.empty()) capture::write_png(file, picture);
    return picture;
  }

  recon::TriangleMesh body(int frame) {
    const auto file = folder_ / fmt::format("body{:04}.ply", frame);
    if (!folder_.empty() && fs::exists(file)) return recon::read_ply(file);
    const auto body = performance().surfaces_at(simulator::act_seconds(frame)).front();
    if (!folder_.empty()) recon::write_ply(file, body);
    return body;
  }

  std::vector<capture::Matte> keyed(const char* kept, const std::vector<cv::Mat>& pictures, int frame,
                                    const std::vector<capture::CameraModel>& cameras) {
    std::vector<capture::Matte> mattes;
    std::optional<recon::SupportedMattes> supported;
    const auto supported_matte = [&](std::size_t i) {
      if (!supported)
        supported = recon::supported_mattes(cameras, alone(pictures, cameras), {.bounds = simulator::kStageVolume});
      return supported->mattes[i].alpha;
    };
    for (std::size_t i = 0; i < pictures.size(); ++i)
      mattes.push_back({get(name(kept, frame, i), 1, [&] { return supported_matte(i); })});
    return mattes;
  }

  std::vector<capture::Matte> alone(const std::vector<cv::Mat>& pictures,
                                    const std::vector<capture::CameraModel>& cameras) {
    std::vector<capture::Matte> mattes;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const cv::Mat plate = get(fmt::format("plate{:02}", i), 3, [&] { return as_received(studio().clean_plate(i)); });
      const cv::Mat stage = capture::stage_mask(cameras[i], simulator::kStageVolume);
      mattes.push_back(capture::chroma_key(pictures[i], {.backdrop = {}, .stage = stage}, plate));
    }
    return mattes;
  }

  simulator::Performance& performance() {
    if (!performance_) performance_ = simulator::make_performance({.person = study_.person, .act = study_.act});
    return *performance_;
  }
  simulator::SceneRenderer& studio() {
    if (!studio_) studio_ = std::make_unique<simulator::SceneRenderer>(performance(), study_.cameras);
    return *studio_;
  }

  const SurfaceStudy& study_;
  std::vector<capture::CameraModel> own_cameras_;
  fs::path folder_;
  std::unique_ptr<simulator::Performance> performance_;
  std::unique_ptr<simulator::SceneRenderer> studio_;
};

std::vector<capture::CameraModel> wide() {
  return simulator::camera_layout({.radius = 6.0, .whole_volume = true});
}

}  // namespace

std::vector<SurfaceStudy> fitted_studies() {
  const auto ten = simulator::camera_layout();
  const auto sixteen = simulator::camera_layout({.cameras = 16, .width = 640, .height = 480, .radius = 4.0});
  const auto six = simulator::camera_layout({.cameras = 6, .width = 1024, .height = 768, .radius = 3.4});
  return {{"anna", "walk", {9}, "ten", ten},        {"bo", "dance", {20, 41}, "ten", ten},
          {"bo", "kick", {24}, "wide", wide()},     {"anna", "capoeira", {60}, "wide", wide()},
          {"anna", "jog", {5}, "sixteen", sixteen}, {"bo", "walk", {14}, "six", six},
          {"carla", "turn", {12}, "ten", ten}};
}

std::vector<SurfaceStudy> held_out_studies() {
  const auto ten = simulator::camera_layout();
  const auto low = simulator::camera_layout({.radius = 3.4, .ring_height = 1.0, .aspect = 16.0 / 15.0});
  const auto twelve =
      simulator::camera_layout({.cameras = 12, .radius = 3.9, .ring_height = 1.55, .k1 = -0.12, .k2 = 0.03});
  return {{"alex", "walk", {5}, "ten", ten},         {"alex", "kick", {26}, "low", low},
          {"dan", "dance", {33}, "ten", ten},        {"carla", "capoeira", {70}, "ten", ten},
          {"dan", "hands-on-hips", {0}, "low", low}, {"carla", "jog", {8}, "wide", wide()},
          {"alex", "jog", {11}, "twelve", twelve}};
}

std::vector<SurfaceMoment> moments_of(const SurfaceStudy& study, const fs::path& keep) {
  MomentSource source(study, keep);
  std::vector<SurfaceMoment> moments;
  for (const int frame : study.frames) moments.push_back(source.moment(frame));
  return moments;
}

}  // namespace rotunda::bench
