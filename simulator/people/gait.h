#pragma once
// Going along +x over the floor at a cadence and speed that may change on the way: walking, jogging, from a stand, to a
// stand. The joint angles are those of gait_style.h; the standing legs are closed onto the floor by inverse kinematics,
// heel first, flat, then over the ball. Metres, seconds, world.
#include <optional>
#include <vector>

#include "simulator/people/gait_style.h"
#include "simulator/people/sole.h"

namespace rotunda::simulator {

struct HeelStrike {
  double seconds;
  Side side;
};

// From one value to another, smoothly between two times.
struct Ramp {
  double from = 0.0, to = 0.0;
  double start = 0.0, end = 1.0;
  double at(double seconds) const;
  double integral(double seconds) const;  // from time 0, which lies not after `start`
};

struct GaitCourse {
  Ramp cadence, speed;  // strides a second; metres a second of a person of 1.75 m
  Ramp jogging;         // 0 walking, 1 jogging
  double phase = 0.0;   // at time 0, in strides: whole when the left heel strikes
  double x = 0.0;       // of the pelvis at time 0
  // Both feet stand as idle's do until the time (from the time on); there is nothing to step over before (after) it.
  std::optional<double> stands_until, stands_from;
};
GaitCourse steady(const GaitStyle& style);

class Gait {
 public:
  // Foot contacts are planned for the times from `begin` to `end`.
  Gait(const Skeleton& skeleton, const GaitCourse& course, double begin, double end);

  double phase(double seconds) const;
  double distance(double seconds) const;  // x of the pelvis' place
  Posture posture(double seconds) const;  // of the gait alone
  // Given the height of the pelvis joint (it decides how far a swinging foot hangs down).
  std::array<LegPlacement, 2> legs(double seconds, double pelvis_height) const;
  std::vector<HeelStrike> heel_strikes(double begin, double end) const;  // in [begin, end), in order

 private:
  struct Contact {
    double phase, on, off;  // strike in strides of this foot; seconds
    FootSpot spot;
    bool from_standing = false, to_standing = false;
  };
  struct Blend {
    double jogging;
    double between(double walk, double jog) const { return walk + jogging * (jog - walk); }
  };
  Blend blend_at(double seconds) const { return {course_.jogging.at(seconds)}; }
  double time_of_phase(double phase) const;
  Contact contact(Side side, double strike) const;
  void plan(Side side, double begin, double end);
  double toe_off(const Contact& contact) const;
  double pitch(const Contact& contact, double seconds) const;
  LegPlacement stance(const Contact& contact, double seconds) const;
  LegPlacement swing(const Contact& from, const Contact& to, double seconds, double pelvis_height) const;
  Eigen::Vector2d free_ankle(const Contact& contact, double seconds, double pelvis_height) const;

  Skeleton skeleton_;
  Sole sole_;
  double scale_;
  GaitCourse course_;
  std::array<std::vector<Contact>, 2> contacts_;
};

// Where idle's feet stand: ankles beside the pelvis at x, slightly turned out.
FootSpot idle_spot(const Skeleton& skeleton, Side side, double x);

}  // namespace rotunda::simulator
