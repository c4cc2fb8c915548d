#pragma once
// 3D video (de Aguiar et al. 2007, 5.2; ALGORITHMS step 14): the performer's own scan, moved as they moved, in the
// colours of the pictures they moved in, from any viewpoint. Visibility and mixing are those of view-dependent
// rendering; where no camera sees the scan it keeps its own colours. Beside it, if asked, the template of motion
// capture in the same pictures: what the paper compares with.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include "playback/render/frame_painter.h"
#include "recon/deform/scan_animation.h"

namespace rotunda::playback {

// Frame 0 is the motion's first. All are lent or shared; the pictures are those of the take that the motion was
// captured from.
std::unique_ptr<FramePainter> scan_painter(recon::ScanAnimation& animation, const recon::CapturedMotion& motion,
                                           std::shared_ptr<TakePictures> pictures);
std::unique_ptr<FramePainter> template_painter(const recon::CapturedMotion& motion,
                                               std::shared_ptr<TakePictures> pictures);

struct ScanVideoOptions {
  std::filesystem::path output;  // FILE.mp4 or a folder of pictures
  std::filesystem::path take;
  std::optional<std::filesystem::path> calibration;  // instead of the take's own
  bool beside_template = false;
  int width = 720, height = 720;  // of each of the pictures side by side, pixels, even
  double turns = 1.0;             // of the eye round the performer
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::stop_token stop;
};

// Draws headless: no other GL context may be current on this thread. Throws InvalidInput, CorruptData, DeviceError (no
// driver), std::system_error, also if it was asked to stop.
void write_scan_video(recon::ScanAnimation& animation, const recon::CapturedMotion& motion,
                      const ScanVideoOptions& options);

}  // namespace rotunda::playback
