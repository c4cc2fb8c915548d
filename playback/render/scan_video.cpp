#include "playback/render/scan_video.h"

#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/render/orbit_film.h"

namespace rotunda::playback {
namespace {

std::vector<Eigen::Vector3d> root_path(const recon::CapturedMotion& motion) {
  std::vector<Eigen::Vector3d> path;
  for (const auto& frame : motion.frames) path.push_back(frame.fit.pose.root);
  return path;
}

// What the body reaches about its root over all frames.
Eigen::AlignedBox3d reach_of(const recon::CapturedMotion& motion) {
  Eigen::AlignedBox3d box;
  for (const auto& frame : motion.frames)
    for (const auto& position : recon::pose_template(motion.body, frame.fit.pose).positions)
      box.extend(position.cast<double>() - frame.fit.pose.root);
  return box;
}

}  // namespace

std::unique_ptr<FramePainter> scan_painter(recon::ScanAnimation& animation, const recon::CapturedMotion& motion,
                                           std::shared_ptr<TakePictures> pictures) {
  auto posed = [&animation, poses = animation.handle_poses_in_studio(motion)](int frame) {
    recon::TriangleMesh mesh = animation.rest();
    const std::span all(poses);
    animation.deform(all.subspan(static_cast<std::size_t>(frame) * recon::kBodySegments, recon::kBodySegments),
                     mesh.positions);
    recon::compute_normals(mesh);
    return mesh;
  };
  return view_dependent_painter(std::move(posed), std::move(pictures), motion.first_frame);
}

std::unique_ptr<FramePainter> template_painter(const recon::CapturedMotion& motion,
                                               std::shared_ptr<TakePictures> pictures) {
  auto posed = [&motion](int frame) {
    return recon::pose_template(motion.body, motion.frames[static_cast<std::size_t>(frame)].fit.pose);
  };
  return view_dependent_painter(std::move(posed), std::move(pictures), motion.first_frame);
}

void write_scan_video(recon::ScanAnimation& animation, const recon::CapturedMotion& motion,
                      const ScanVideoOptions& options) {
  const HeadlessDisplay display;
  const auto pictures = std::make_shared<TakePictures>(options.take, options.calibration);
  std::vector<std::unique_ptr<FramePainter>> painters;
  painters.push_back(scan_painter(animation, motion, pictures));
  if (options.beside_template) painters.push_back(template_painter(motion, pictures));
  std::vector<FramePainter*> lent;
  for (const auto& painter : painters) lent.push_back(painter.get());
  const auto film = make_film_writer(
      options.output,
      {.width = options.width * static_cast<int>(lent.size()), .height = options.height, .fps = motion.fps});
  OrbitFilmOptions orbit{.width = options.width, .height = options.height, .turns = options.turns};
  orbit.progress = [&](int done, int all) {
    if (options.progress) options.progress(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
  orbit.stop = options.stop;
  const auto path = root_path(motion);
  render_orbit({path, reach_of(motion), motion.fps}, lent, orbit, *film);
  if (options.stop.stop_requested())
    throw std::system_error(std::make_error_code(std::errc::operation_canceled), "stopped");
}

}  // namespace rotunda::playback
