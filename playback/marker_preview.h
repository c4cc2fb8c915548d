#pragma once
// The scan under the markers as they are edited, in the frame that is looked at, made in a thread of its own
// (`preview`) so that the window never waits for it: binding three hundred thousand triangles takes seconds. The newest
// wish counts.
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "recon/deform/scan_animation.h"

namespace rotunda::playback {

struct PreviewWish {
  long revision = 0;         // of the markers
  std::optional<int> frame;  // of the motion; nothing: as scanned
  bool residuals = false;
  bool operator==(const PreviewWish&) const = default;
};

struct Preview {
  PreviewWish of;
  recon::TriangleMesh body, scan;  // the template and the scan as they stand, with normals
  // Of each vertex of either to the other's surface, metres, kResidualReach where it is farther; empty: not asked for.
  std::vector<float> body_residuals, scan_residuals;
  Eigen::Vector3d performer = Eigen::Vector3d::Zero();  // where the pelvis is
  std::string told;  // why these markers cannot carry the scan, which then moves as with the last that could
};

inline constexpr double kResidualReach = 0.10;  // metres

class MarkerPreview {
 public:
  // Keeps a reference to the scan. Throws InvalidInput for a motion without a frame.
  MarkerPreview(const recon::PreparedScan& scan, const recon::TemplateFit& fit, const recon::BodyMotion& motion);

  void wish(const PreviewWish& wish, const recon::Markers& markers);
  // The last made; before the first the scan as it was scanned. Throws what making it threw.
  std::shared_ptr<const Preview> newest() const;
  std::shared_ptr<const Preview> wait_for(const PreviewWish& wish, const recon::Markers& markers);
  bool binds() const;  // new markers, now

 private:
  void work(const std::stop_token& stop);
  Preview make(const PreviewWish& wish, const recon::Markers& markers);
  void bind(const PreviewWish& wish, const recon::Markers& markers);

  // Of the thread.
  const recon::PreparedScan& scan_;
  const recon::TemplateFit fit_;
  const recon::BodyMotion motion_;
  std::vector<recon::Pose> body_poses_;
  std::optional<recon::ScanAnimation> animation_;
  std::vector<recon::HandlePose> handle_poses_;
  std::optional<long> bound_;  // the revision of the markers last bound, or tried to
  std::string told_;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  PreviewWish wish_;
  recon::Markers markers_;
  std::shared_ptr<const Preview> newest_;
  std::exception_ptr error_;
  bool binds_ = false;
  std::jthread thread_;  // last: the first to end
};

}  // namespace rotunda::playback
