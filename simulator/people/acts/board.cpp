// A person carries the calibration board on its path (board_act.h): the feet step under it, knees and trunk bend to
// where it is low, both hands hold its edges.
#include <utility>

#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"
#include "simulator/people/board_grip.h"
#include "simulator/people/key_curve.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator::acts {
namespace {

using Eigen::Vector2d;

constexpr double kSeconds = kBoardActFrames * kActStep;
constexpr double kLetGo = kBoardLaidSeconds + 0.35;  // the hands leave the board and the body rises
constexpr double kUp = kBoardLaidSeconds + 2.0;      // upright again

// The carrier at a moment, as the board asks for it.
struct Carrier {
  Vector2d place;  // of the weight on the floor, metres
  double heading;  // degrees, running on over whole turns
  double height;   // of the board, metres of a person of 1.75 m
};

class Carrying {
 public:
  explicit Carrying(const Skeleton& skeleton) : skeleton_(skeleton), tall_(skeleton.height / 1.75) {}

  Carrier at(double seconds) const {
    const double when = std::clamp(seconds, 0.0, kBoardLaidSeconds);
    const Eigen::Isometry3d board = board_pose(when);
    const double heading = board_facing(when), height = board.translation().z() / tall_;
    const Vector2d ahead = Eigen::Rotation2Dd(radians(heading)) * Vector2d::UnitX();
    const double back = kStepBack * smooth_step((seconds - kUp) / 0.9);
    return {board.translation().head<2>() - tall_ * (kReach + back) * ahead, heading, height};
  }

  Posture posture(double seconds) const;
  std::vector<Step> steps() const;
  HandHold hold(Side side, double seconds) const {
    const double letting_go = smooth_step((seconds - kBoardLaidSeconds) / 0.3);
    const Eigen::Isometry3d board = board_pose(seconds);
    HandHold hold = grip(skeleton_, side, board, {.heading = radians(at(seconds).heading), .apart = 0.05 * letting_go});
    hold.share = 1.0 - smooth_step((seconds - kLetGo) / 0.6);
    return hold;
  }

 private:
  static constexpr double kReach = 0.42, kStepBack = 0.30;  // of the board before the weight

  Skeleton skeleton_;
  double tall_;
};

// The body of one who holds something with both hands at a height, metres of a person of 1.75 m: how far the pelvis is
// let down, how far it and the trunk lean, how far the head bends down and the arms are lifted.
constexpr std::array<CurveKey<5>, 8> kReaching = {{{0.00, {-0.47, 51, 67, 20, 60}},
                                                   {0.20, {-0.44, 46, 54, 22, 60}},
                                                   {0.40, {-0.36, 34, 32, 24, 55}},
                                                   {0.65, {-0.24, 28, 26, 20, 45}},
                                                   {0.90, {-0.10, 16, 16, 14, 40}},
                                                   {1.15, {-0.03, 4, 4, 5, 40}},
                                                   {1.40, {-0.03, 2, 0, -4, 75}},
                                                   {1.75, {-0.01, 2, -4, -14, 115}}}};

Posture Carrying::posture(double seconds) const {
  const Carrier now = at(seconds);
  const auto [height, tilt, bend, nod, lift] = curve_at<5>(kReaching, now.height);
  Posture p;
  p.height = height;
  p.yaw = now.heading;
  p.tilt = tilt;
  p.bend = bend;
  p.nod = nod;
  for (auto& arm : p.arm) arm = {.abduction = 14.0, .flexion = lift, .rotation = 8.0, .elbow = 50.0, .curl = 32.0};
  return p;
}

// Left and right by turns, each to where the weight will be while it stands; no step where it would lead nowhere.
std::vector<Step> Carrying::steps() const {
  constexpr double kRhythm = 0.48, kSwing = 0.38, kApart = 0.125, kToeOut = 11.0;
  constexpr double kNear = 0.05, kTurned = 14.0;  // metres, degrees: not worth a step
  constexpr double kDeep = 0.85;                  // nobody steps bent down as deep as for a board at this height
  const double scale = leg_scale(skeleton_);
  std::vector<Step> steps;
  std::array<Vector2d, 2> stood = {Vector2d(0.0, 0.112), Vector2d(0.0, -0.112)};
  std::array<double, 2> yaw = {9.0, -9.0};
  const auto step = [&](Side side, double lift, const Carrier& to, double apart, double toe_out) {
    const double s = sign_of(side), to_yaw = to.heading + s * toe_out;
    const Vector2d spot = to.place / scale + Eigen::Rotation2Dd(radians(to.heading)) * Vector2d(-0.067, s * apart);
    auto& from = stood[simulator::at(side)];
    auto& from_yaw = yaw[simulator::at(side)];
    if ((spot - from).norm() < kNear && std::abs(to_yaw - from_yaw) < kTurned) return;
    steps.push_back({side, lift, lift + kSwing, spot, to_yaw, 0.05});
    from = spot;
    from_yaw = to_yaw;
  };
  Side side = Side::right;
  double lift = 0.4;
  for (; lift < kBoardLaidSeconds; lift += kRhythm, side = other(side))
    if (at(lift + 0.5 * kSwing).height > kDeep) step(side, lift, at(lift + kRhythm + 0.5 * kSwing), kApart, kToeOut);
  lift = kUp + 0.1;
  for (const Side last : {Side::right, Side::left})
    step(last, std::exchange(lift, lift + 0.55), at(kSeconds), 0.112, 9.0);
  return steps;
}

}  // namespace

Motion board(const Skeleton& skeleton, const MotionOptions& options) {
  constexpr double kKeys = 0.15;  // seconds between
  const Carrying carrying(skeleton);
  KeyedMotion table{.name = "board", .frames = kBoardActFrames, .keys = {}, .feet = {}, .hands = {}, .holds = {}};
  for (double t = 0.0; t < kLetGo; t += kKeys) table.keys.push_back({t, carrying.posture(t)});
  Posture stand = idle_posture(0.0, options.seed);
  stand.yaw += carrying.at(kSeconds).heading;
  table.keys.push_back({kUp + 0.2, stand});
  table.feet.steps = carrying.steps();
  table.holds = [carrying](Side side, double seconds) { return carrying.hold(side, seconds); };
  return keyed_motion(skeleton, table, options.seed);
}

}  // namespace rotunda::simulator::acts
