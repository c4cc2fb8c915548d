// idle-walk, walk-idle, walk-jog, jog-walk: through the volume, from the very pose, phase and speed of one cycle to
// those of the next.
#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"
#include "simulator/people/key_curve.h"

namespace rotunda::simulator::acts {
namespace {

// Moves the whole way so that its middle is the volume's.
GaitCourse centred(const Skeleton& skeleton, GaitCourse course, double seconds) {
  course.x = -0.5 * leg_scale(skeleton) * course.speed.integral(seconds);
  return course;
}

Pose pose_of(const Skeleton& skeleton, const Gait& gait, const Posture& posture, double seconds) {
  const double height = standing_height(skeleton) + leg_scale(skeleton) * posture.height;
  return standing_pose(skeleton, posture, {gait.distance(seconds), 0.0}, gait.legs(seconds, height));
}

Motion between_gaits(const char* name, const Skeleton& skeleton, const GaitStyle& from, const GaitStyle& to) {
  // Two strides in 43 frames: the middle of the cadence's ramp follows from that.
  constexpr int kFrames = 43;
  constexpr double kSeconds = kFrames * kActStep, kStrides = 2.0, kHalfRamp = 0.34;
  const double slow = 1.0 / from.period, fast = 1.0 / to.period;
  const double middle = kSeconds - (kStrides - slow * kSeconds) / (fast - slow);
  const auto ramp = [&](double a, double b) { return Ramp{a, b, middle - kHalfRamp, middle + kHalfRamp}; };
  GaitCourse course;
  course.cadence = ramp(slow, fast);
  course.speed = ramp(from.speed, to.speed);
  course.jogging = ramp(&from == &jogging() ? 1.0 : 0.0, &to == &jogging() ? 1.0 : 0.0);
  const Gait gait(skeleton, centred(skeleton, course, kSeconds), 0.0, kSeconds);
  const auto pose_at = [skeleton, gait](double seconds) {
    return pose_of(skeleton, gait, gait.posture(seconds), seconds);
  };
  return {name, kFrames, false, gait.heel_strikes(0.0, kSeconds), pose_at};
}

}  // namespace

// The left foot steps first, then the right; the second left strike ends it (Breniere and Do 1986: a steady gait is
// reached within one to two steps).
Motion idle_walk(const Skeleton& skeleton, const MotionOptions& options) {
  constexpr int kFrames = 50;
  constexpr double kSeconds = kFrames * kActStep;
  const GaitStyle& style = walking();
  GaitCourse course = steady(style);
  course.speed = {0.0, style.speed, 0.22, 1.45};
  course.phase = -kSeconds / style.period;
  course.stands_until = 0.4;
  const Gait gait(skeleton, centred(skeleton, course, kSeconds), 0.0, kSeconds);
  const auto pose_at = [skeleton, gait, seed = options.seed](double seconds) {
    const double walked = smooth_step((seconds - 0.15) / 1.2);
    return pose_of(skeleton, gait, blend(idle_posture(seconds, seed), gait.posture(seconds), walked), seconds);
  };
  return {"idle-walk", kFrames, false, gait.heel_strikes(0.0, kSeconds), pose_at};
}

// One shorter step of the right foot, then the left comes beside it.
Motion walk_idle(const Skeleton& skeleton, const MotionOptions& options) {
  constexpr int kFrames = 50;
  constexpr double kSeconds = kFrames * kActStep;
  const GaitStyle& style = walking();
  GaitCourse course = steady(style);
  course.speed = {style.speed, 0.0, 0.0, 1.34};
  course.stands_from = 1.1;
  const Gait gait(skeleton, centred(skeleton, course, kSeconds), 0.0, kSeconds);
  const auto pose_at = [skeleton, gait, seed = options.seed](double seconds) {
    const double stood = smooth_step((seconds - 0.25) / 1.35);
    const Posture idle = idle_posture(seconds - kSeconds, seed);
    return pose_of(skeleton, gait, blend(gait.posture(seconds), idle, stood), seconds);
  };
  return {"walk-idle", kFrames, false, gait.heel_strikes(0.0, kSeconds), pose_at};
}

Motion walk_jog(const Skeleton& skeleton, const MotionOptions&) {
  return between_gaits("walk-jog", skeleton, walking(), jogging());
}

Motion jog_walk(const Skeleton& skeleton, const MotionOptions&) {
  return between_gaits("jog-walk", skeleton, jogging(), walking());
}

}  // namespace rotunda::simulator::acts
