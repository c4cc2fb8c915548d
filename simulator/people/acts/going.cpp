// walk and jog: on the spot as on a treadmill, or through the volume.
#include <cmath>

#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"

namespace rotunda::simulator::acts {
namespace {

constexpr double kTravelled = 2.75;  // metres the pelvis may go in the volume of 3 m

Pose gait_pose(const Skeleton& skeleton, const Gait& gait, double seconds, double floor_back) {
  const Posture posture = gait.posture(seconds);
  const double height = standing_height(skeleton) + leg_scale(skeleton) * posture.height;
  auto legs = gait.legs(seconds, height);
  for (auto& leg : legs) leg.ankle.x() -= floor_back;
  return standing_pose(skeleton, posture, {gait.distance(seconds) - floor_back, 0.0}, legs);
}

// The floor under the standing foot runs back at the style's speed.
Motion on_the_spot(const char* name, const GaitStyle& style, const Skeleton& skeleton) {
  const Gait gait(skeleton, steady(style), 0.0, style.period);
  const auto pose_at = [skeleton, gait](double seconds) {
    return gait_pose(skeleton, gait, seconds, gait.distance(seconds));
  };
  const int frames = static_cast<int>(std::lround(style.period / kActStep));
  return {name, frames, true, gait.heel_strikes(0.0, style.period), pose_at};
}

// As many whole strides as the volume holds, its middle in theirs.
Motion through_the_volume(const char* name, const GaitStyle& style, const Skeleton& skeleton) {
  const double stride = leg_scale(skeleton) * style.speed * style.period;
  const double strides = std::max(1.0, std::floor(kTravelled / stride)), seconds = strides * style.period;
  GaitCourse course = steady(style);
  course.x = -0.5 * strides * stride;
  const Gait gait(skeleton, course, 0.0, seconds);
  const auto pose_at = [skeleton, gait](double when) { return gait_pose(skeleton, gait, when, 0.0); };
  const int frames = static_cast<int>(std::lround(seconds / kActStep));
  return {name, frames, false, gait.heel_strikes(0.0, seconds), pose_at};
}

Motion going(const char* name, const GaitStyle& style, const Skeleton& skeleton, const MotionOptions& options) {
  return options.travel ? through_the_volume(name, style, skeleton) : on_the_spot(name, style, skeleton);
}

}  // namespace

Motion walk(const Skeleton& skeleton, const MotionOptions& options) {
  return going("walk", walking(), skeleton, options);
}

Motion jog(const Skeleton& skeleton, const MotionOptions& options) {
  return going("jog", jogging(), skeleton, options);
}

}  // namespace rotunda::simulator::acts
