#include "recon/take_studio.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/calibration_file.h"
#include "capture/matte/stage_mask.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "config/rig_config.h"
#include "recon/frame_store.h"
#include "recon/mesh/mesh_file.h"
#include "recon/take_plates.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

// The calibration's cameras in the take's order. Tells every camera that is missing or of another size.
std::vector<capture::CameraModel> cameras_of(const capture::TakeInfo& take, const capture::CalibrationFile& calibration,
                                             const fs::path& file) {
  std::vector<capture::CameraModel> cameras;
  std::string mistakes;
  for (const auto& camera : take.cameras) {
    const auto found = std::find_if(calibration.cameras.begin(), calibration.cameras.end(),
                                    [&](const auto& model) { return model.name == camera.name; });
    if (found == calibration.cameras.end())
      mistakes += fmt::format("\n  {} is in the take but not in the calibration", camera.name);
    else if (found->width != camera.width || found->height != camera.height)
      mistakes += fmt::format("\n  {} is calibrated for {} x {}, but its pictures are {} x {}", camera.name,
                              found->width, found->height, camera.width, camera.height);
    else
      cameras.push_back(*found);
  }
  if (!mistakes.empty())
    throw InvalidInput(
        fmt::format("{} does not fit take {}:{}\ncalibrate this rig, or name another file with "
                    "--calibration",
                    file.string(), take.name, mistakes));
  return cameras;
}

// The screen's colour in most of the cameras' plates or first pictures, blue where none tells.
capture::Backdrop backdrop_seen(const capture::TakeReader& take, const std::vector<cv::Mat>& plates) {
  int green_lead = 0;
  for (std::size_t i = 0; i < plates.size(); ++i) {
    const cv::Mat rgb = !plates[i].empty()            ? plates[i]
                        : take.frame_set_count() == 0 ? cv::Mat()
                                                      : capture::picture_of(take.read(0, i)).rgb;
    const auto seen = rgb.empty() ? std::nullopt : capture::backdrop_of(rgb);
    if (seen) green_lead += *seen == capture::Backdrop::green ? 1 : -1;
  }
  return green_lead > 0 ? capture::Backdrop::green : capture::Backdrop::blue;
}

}  // namespace

TakeStudio read_take_studio(const capture::TakeReader& take, const std::optional<fs::path>& calibration_file) {
  const auto file = calibration_file.value_or(capture::calibration_file(take.folder()));
  if (!fs::exists(file))
    throw InvalidInput(fmt::format("{} is missing; name a calibration with --calibration", file.string()));
  const auto calibration = capture::read_calibration_file(file);
  TakeStudio studio;
  studio.unit = studio.views.unit = calibration.unit;
  studio.views.cameras = cameras_of(take.info(), calibration, file);
  if (!calibration.colour.empty())
    for (const auto& camera : take.info().cameras) studio.views.colour.push_back(calibration.colour_of(camera.name));
  for (const auto& camera : take.info().cameras) {
    const auto background = capture::background_file(take.folder(), camera.name);
    const auto learnt = learnt_plate_file(take.folder(), camera.name);
    studio.views.backgrounds.push_back(fs::exists(background) ? capture::read_rgb(background)
                                       : fs::exists(learnt)   ? capture::read_rgb(learnt)
                                                              : cv::Mat());
  }
  const auto rig_file = take.folder() / "rig.yaml";
  if (!fs::exists(rig_file)) {
    studio.views.backdrop = backdrop_seen(take, studio.views.backgrounds);
    return studio;
  }
  const auto rig = config::load_rig(rig_file);
  studio.views.backdrop = rig.backdrop == "green" ? capture::Backdrop::green : capture::Backdrop::blue;
  studio.volume = Eigen::AlignedBox3d(Eigen::Vector3d(rig.volume.min.data()), Eigen::Vector3d(rig.volume.max.data()));
  studio.views.volume = studio.volume;
  for (const auto& camera : studio.views.cameras)
    studio.views.stages.push_back(capture::stage_mask(camera, *studio.volume));
  return studio;
}

std::vector<capture::Matte> given_mattes(const capture::TakeReader& take, std::size_t frame) {
  std::vector<capture::Matte> mattes;
  for (const auto& camera : take.info().cameras) {
    const auto file = capture::matte_file(take.folder(), camera.name, frame);
    mattes.push_back({fs::exists(file) ? capture::read_grey(file) : cv::Mat()});
  }
  return mattes;
}

fs::path geometry_video_of(const fs::path& take) {
  return take / "recon" / "geometry.mkv";
}

std::optional<TriangleMesh> frame_surface(const fs::path& take, std::size_t frame) {
  const auto file = FrameStore::folder_of(take) / capture::frame_file_name(frame, "ply");
  if (!fs::exists(file)) return std::nullopt;
  return read_ply(file);
}

std::optional<GeometryImage> frame_image(const fs::path& take, std::size_t frame) {
  const FrameStore store(FrameStore::folder_of(take));
  if (!store.finished(frame) || store.failure(frame)) return std::nullopt;
  return store.image(frame);
}

}  // namespace rotunda::recon
