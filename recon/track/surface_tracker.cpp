#include "recon/track/surface_tracker.h"

#include <Eigen/Geometry>
#include <utility>

namespace rotunda::recon {
namespace {

constexpr double kLost = 0.03;  // share of the surface that no sample is near to

}  // namespace

std::vector<NodeMotion> SurfaceTracker::predicted() const {
  auto next = now_;
  for (std::size_t n = 0; n < next.size(); ++n) {
    next[n].rotation = now_[n].rotation * before_[n].rotation.transpose() * now_[n].rotation;
    next[n].shift = 2.0 * now_[n].shift - before_[n].shift;
  }
  return next;
}

void SurfaceTracker::follow(const SurfaceTarget& target) {
  auto next = predicted();
  const double uncovered = register_surface(*model_, target, next, {});
  if (uncovered > kLost) {  // from where it was, and farther around
    auto again = now_;
    const RegistrationOptions wide{.gates = {0.4, 0.25, 0.15, 0.09, 0.05, 0.05, 0.05}};
    if (register_surface(*model_, target, again, wide) < uncovered) next = std::move(again);
  }
  before_ = std::exchange(now_, std::move(next));
}

void SurfaceTracker::skip() {
  auto next = predicted();
  before_ = std::exchange(now_, std::move(next));
}

}  // namespace rotunda::recon
