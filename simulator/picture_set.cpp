#include "simulator/picture_set.h"

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "simulator/studio/truth.h"

namespace rotunda::simulator {

int write_picture_set(const std::filesystem::path& directory, SceneRenderer& studio, int frames,
                      const std::stop_token& stop, const std::function<void(int)>& progress) {
  const auto& cameras = studio.cameras();
  const TruthFiles truth(directory / "truth", studio.performance(), cameras, frames, /*key=*/{}, studio.sensor());
  std::filesystem::create_directories(directory / "background");
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    std::filesystem::create_directories(directory / "images" / cameras[camera].name);
    capture::write_png(directory / "background" / (cameras[camera].name + ".png"), studio.clean_plate(camera));
  }
  capture::write_calibration(directory / "calibration.yaml", cameras);
  for (int frame = 0; frame < frames; ++frame) {
    if (stop.stop_requested()) return frame;
    const auto pictures = studio.pictures(act_seconds(frame), static_cast<std::uint64_t>(frame));
    for (std::size_t camera = 0; camera < cameras.size(); ++camera)
      capture::write_png(directory / "images" / cameras[camera].name / (frame_name(frame) + ".png"),
                         pictures[camera].rgb);
    truth.write_frame(frame, pictures);
    if (progress) progress(frame + 1);
  }
  return frames;
}

}  // namespace rotunda::simulator
