#include "simulator/people/board_grip.h"

#include <algorithm>
#include <cmath>

#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

// From the wrist along the hand, towards the thumb, into the palm; metres at 1.75 m.
constexpr std::array<double, 3> kCarrying = {0.090, -0.002, 0.0135};  // the plate lies in the fingers' roots
constexpr std::array<double, 3> kLaying = {0.135, -0.050, 0.0100};    // between the little fingers' ends
constexpr double kHook = 3.0, kStretched = 0.25;                      // of curl_fingers
constexpr double kThumbBehind = 58.0, kThumbOver = 40.0;              // degrees towards the palm

double scale_of(const Skeleton& skeleton) {
  return skeleton.height / 1.75;
}

struct BoardAngles {
  double tilt;   // of the face upwards, radians
  double pitch;  // of the hands upwards: arms point up to what is high, down to what is low
};
BoardAngles angles_of(const Skeleton& skeleton, const Eigen::Isometry3d& world_from_board) {
  const double tilt = std::asin(std::clamp(world_from_board.linear()(2, 2), -1.0, 1.0));
  const double height = world_from_board.translation().z() / scale_of(skeleton);
  const double rising =
      radians(-38.0 + 38.0 * smooth_step((height - 0.45) / 0.70) + 34.0 * smooth_step((height - 1.15) / 0.55));
  const double laid = smooth_step((0.40 - height) / 0.35) * smooth_step((tilt - radians(45.0)) / radians(40.0));
  return {tilt, rising + laid * (radians(-15.0) - rising)};
}

// Against the face's direction, in the plane of the edge.
double turn_of(const BoardAngles& angles) {
  return std::clamp(angles.pitch - angles.tilt, radians(-110.0), radians(60.0));
}

double flatness(double turn) {
  return smooth_step((-turn - radians(55.0)) / radians(45.0));
}

std::array<double, 3> hold_at(double flat) {
  std::array<double, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) at[i] = kCarrying[i] + flat * (kLaying[i] - kCarrying[i]);
  return at;
}

}  // namespace

Vector3d held_point(const CarriedBoard& plate, Side side) {
  return {sign_of(side) * 0.5 * plate.width, 0.0, -0.5 * plate.thickness};
}

Vector3d holding_point(const Skeleton& skeleton, Side side, double flat) {
  const Vector3d wrist = skeleton.joint[index(on_side(Joint::hand_left, side))];
  const Vector3d along = (wrist - skeleton.joint[index(on_side(Joint::forearm_left, side))]).normalized();
  const Vector3d palm = along.cross(Vector3d::UnitX()) * sign_of(side);
  const auto [a, across, in] = hold_at(flat);
  return wrist + scale_of(skeleton) * (a * along + across * Vector3d::UnitX() + in * palm);
}

double flatness_of_grip(const Skeleton& skeleton, const Eigen::Isometry3d& world_from_board) {
  return flatness(turn_of(angles_of(skeleton, world_from_board)));
}

HandHold grip(const Skeleton& skeleton, Side side, const Eigen::Isometry3d& world_from_board,
              const GripOptions& options, const CarriedBoard& plate) {
  const double s = sign_of(side), turn = turn_of(angles_of(skeleton, world_from_board)), flat = flatness(turn);
  const Eigen::Matrix3d board = world_from_board.linear();
  const Vector3d along = std::cos(turn) * board.col(2) + std::sin(turn) * board.col(1), palm = -s * board.col(0);
  HandHold hold;
  hold.hand.hand = hand_towards(skeleton, side, along, palm);
  const Vector3d from_wrist =
      hold.hand.hand * (holding_point(skeleton, side, flat) - skeleton.joint[index(on_side(Joint::hand_left, side))]);
  hold.hand.wrist = world_from_board * held_point(plate, side) - from_wrist - options.apart * palm;
  hold.hand.elbow = Eigen::AngleAxisd(options.heading, Vector3d::UnitZ()) * Vector3d(-0.35, s * 0.7, -0.8);
  hold.curl = kHook + flat * (kStretched - kHook);
  hold.thumb = radians(kThumbBehind + flat * (kThumbOver - kThumbBehind));
  hold.share = 1.0;
  return hold;
}

}  // namespace rotunda::simulator
