#include "playback/marker_preview.h"

#include <pthread.h>

#include "config/errors.h"
#include "recon/deform/surface_distance.h"

namespace rotunda::playback {

MarkerPreview::MarkerPreview(const recon::PreparedScan& scan, const recon::TemplateFit& fit,
                             const recon::BodyMotion& motion)
    : scan_(scan), fit_(fit), motion_(motion), body_poses_(recon::poses_for(motion, fit.body.skeleton)) {
  if (body_poses_.empty()) throw InvalidInput("the motion has no frame");
  newest_ = std::make_shared<const Preview>(make({}, {}));
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  pthread_setname_np(thread_.native_handle(), "preview");
}

void MarkerPreview::wish(const PreviewWish& wish, const recon::Markers& markers) {
  const std::lock_guard lock(mutex_);
  if (wish == wish_) return;
  if (wish.revision != wish_.revision || markers_.pairs.empty()) markers_ = markers;
  wish_ = wish;
  changed_.notify_all();
}

std::shared_ptr<const Preview> MarkerPreview::newest() const {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(error_);
  return newest_;
}

std::shared_ptr<const Preview> MarkerPreview::wait_for(const PreviewWish& wish, const recon::Markers& markers) {
  this->wish(wish, markers);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return error_ || newest_->of == wish; });
  if (error_) std::rethrow_exception(error_);
  return newest_;
}

bool MarkerPreview::binds() const {
  const std::lock_guard lock(mutex_);
  return binds_;
}

void MarkerPreview::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !(wish_ == newest_->of); })) {
    const auto wish = wish_;
    const auto markers = markers_;
    binds_ = wish.frame && bound_ != wish.revision;
    lock.unlock();
    std::shared_ptr<const Preview> made;
    std::exception_ptr error;
    try {
      made = std::make_shared<const Preview>(make(wish, markers));
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    binds_ = false;
    error_ = error;
    if (made) newest_ = made;
    changed_.notify_all();
    if (error || stop.stop_requested()) return;
  }
}

void MarkerPreview::bind(const PreviewWish& wish, const recon::Markers& markers) {
  bound_ = wish.revision;
  told_.clear();
  try {
    recon::ScanAnimation animation(scan_, markers);
    handle_poses_ = animation.handle_poses(motion_);
    animation_ = std::move(animation);
  } catch (const InvalidInput& error) {
    told_ = error.what();
  }
}

Preview MarkerPreview::make(const PreviewWish& wish, const recon::Markers& markers) {
  if (wish.frame && bound_ != wish.revision) bind(wish, markers);
  Preview made{.of = wish, .scan = scan_.mesh, .told = wish.frame ? told_ : ""};
  const auto frame = static_cast<std::size_t>(wish.frame.value_or(0));
  const auto& pose = wish.frame ? body_poses_.at(frame) : fit_.pose;
  made.body = recon::pose_template(fit_.body, pose);
  made.performer = pose.root;
  if (wish.frame && animation_) {
    const auto poses = std::span(handle_poses_).subspan(frame * recon::kBodySegments, recon::kBodySegments);
    animation_->deform(poses, made.scan.positions);
    recon::compute_normals(made.scan);
  }
  if (wish.residuals) {
    made.body_residuals = recon::surface_distances(made.body, made.scan, kResidualReach);
    made.scan_residuals = recon::surface_distances(made.scan, made.body, kResidualReach);
  }
  return made;
}

}  // namespace rotunda::playback
