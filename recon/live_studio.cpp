#include "recon/live_studio.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "capture/calibration_file.h"
#include "capture/matte/stage_mask.h"
#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

capture::CameraModel model_of(const capture::CalibrationFile& calibration, const capture::CameraId& name,
                              const capture::FrameSlot& slot, std::string& mistakes) {
  const auto found = std::find_if(calibration.cameras.begin(), calibration.cameras.end(),
                                  [&](const auto& model) { return model.name == name; });
  if (found == calibration.cameras.end()) {
    mistakes += fmt::format("{}{} is not in it", mistakes.empty() ? "" : "; ", name);
    return {};
  }
  if (slot.frame && (slot.frame->image.width != found->width || slot.frame->image.height != found->height))
    mistakes += fmt::format("{}{} is calibrated for {} x {}, but sends {} x {}", mistakes.empty() ? "" : "; ", name,
                            found->width, found->height, slot.frame->image.width, slot.frame->image.height);
  return *found;
}

cv::Mat plate_of(const fs::path& plates, const capture::CameraId& camera, const cv::Size& size) {
  const auto file = plates / (camera + ".png");
  if (!fs::exists(file)) return {};
  cv::Mat plate = capture::read_rgb(file);
  return plate.size() == size ? plate : cv::Mat();
}

struct CameraKey {
  cv::Mat plate;
  std::optional<capture::LiveKey> key;
  bool fitted = false, no_screen = false;
};

CameraKey key_of(const capture::CameraModel& camera, const capture::FrameSlot& slot, const LiveStudio& studio,
                 const fs::path& plates) {
  CameraKey made;
  made.plate = plate_of(plates, camera.name, {camera.width, camera.height});
  const cv::Mat stage = capture::stage_mask(camera, studio.volume);
  if (!slot.frame) return made;
  cv::Mat plate = made.plate;
  if (plate.empty()) {
    if (const auto picture = capture::picture_of(slot); !picture.rgb.empty())
      plate = capture::fit_plate_picture(picture.rgb, studio.views.backdrop);
    made.fitted = true;
  }
  if (plate.empty() || !capture::is_before_screen(plate, studio.views.backdrop, stage))
    made.no_screen = true;
  else
    made.key.emplace(plate, slot.frame->image.format, capture::LiveKeyOptions{studio.views.backdrop, stage});
  return made;
}

std::vector<std::string> remarks_on(const std::vector<CameraKey>& keys, std::span<const capture::CameraId> cameras) {
  const auto names = [&](bool CameraKey::*flag) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (keys[i].*flag) found.push_back(cameras[i]);
    return found.size() == keys.size() ? std::string("any camera") : fmt::format("{}", fmt::join(found, ", "));
  };
  std::vector<std::string> remarks;
  if (const auto fitted = names(&CameraKey::fitted); !fitted.empty())
    remarks.push_back("no plate of the empty studio for " + fitted + ", a smooth one was fitted: rotunda plate");
  if (const auto without = names(&CameraKey::no_screen); !without.empty())
    remarks.push_back("no screen of the rig's colour before " + without +
                      ", which live surfaces do without or key slowly");
  return remarks;
}

}  // namespace

LiveStudio live_studio(const config::RigConfig& rig, std::span<const capture::CameraId> cameras, const fs::path& plates,
                       const capture::FrameSet& first) {
  if (!rig.calibration || !fs::exists(*rig.calibration))
    throw InvalidInput("the rig has no calibration, which live surfaces need: rotunda calibrate");
  if (first.slots.size() != cameras.size()) throw InvalidInput("a frame set of other cameras than the studio's");
  const auto calibration = capture::read_calibration_file(*rig.calibration);
  LiveStudio studio;
  std::string mistakes;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    studio.views.cameras.push_back(model_of(calibration, cameras[i], first.slots[i], mistakes));
    studio.views.colour.push_back(calibration.colour_of(cameras[i]));
  }
  if (!mistakes.empty())
    throw InvalidInput(fmt::format("{} does not fit the rig: {}; calibrate it anew (rotunda calibrate)",
                                   rig.calibration->string(), mistakes));
  if (calibration.colour.empty()) studio.views.colour.clear();
  studio.views.unit = calibration.unit;
  studio.views.backdrop = rig.backdrop == "green" ? capture::Backdrop::green : capture::Backdrop::blue;
  studio.volume = {Eigen::Vector3d(rig.volume.min.data()), Eigen::Vector3d(rig.volume.max.data())};
  std::vector<CameraKey> keys(cameras.size());
  tbb::parallel_for(std::size_t{0}, keys.size(),
                    [&](std::size_t i) { keys[i] = key_of(studio.views.cameras[i], first.slots[i], studio, plates); });
  for (std::size_t i = 0; i < keys.size(); ++i) {
    studio.views.backgrounds.push_back(keys[i].plate);
    studio.views.stages.push_back(capture::stage_mask(studio.views.cameras[i], studio.volume));
    studio.views.live_keys.push_back(std::move(keys[i].key));
  }
  studio.remarks = remarks_on(keys, cameras);
  return studio;
}

}  // namespace rotunda::recon
