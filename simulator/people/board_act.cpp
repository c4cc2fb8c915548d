#include "simulator/people/board_act.h"

#include <numbers>

#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kOnFloor = CarriedBoard{}.thickness;

// Seconds; x, y, z of the middle, metres; degrees: where the face looks to (0: +x, counter-clockwise), how far it is
// tilted upwards, its roll. Once about with the face outwards, high and low by turns, then once back through the
// middle.
constexpr std::array<CurveKey<6>, 18> kPath = {{{0.0, {0.45, 0.00, 1.15, 0, 0, 0}},
                                                {0.4, {0.45, 0.00, 1.15, 0, 0, 0}},
                                                {1.6, {1.05, 0.10, 1.45, 10, -12, 8}},
                                                {2.6, {1.05, 0.45, 1.55, 60, -20, -10}},
                                                {3.6, {0.45, 0.75, 1.20, 100, 15, 0}},
                                                {4.5, {0.00, 0.75, 0.70, 110, 25, 12}},
                                                {5.4, {-0.55, 0.65, 1.00, 145, 10, -12}},
                                                {6.4, {-1.10, 0.25, 1.50, 185, -15, 0}},
                                                {7.3, {-1.15, -0.15, 1.60, 205, -25, 10}},
                                                {8.2, {-0.75, -0.60, 1.10, 240, 10, -8}},
                                                {9.1, {-0.15, -0.75, 0.65, 270, 28, 0}},
                                                {10.0, {0.40, -0.70, 1.10, 295, 0, 14}},
                                                {10.9, {0.80, -0.35, 1.50, 330, -20, -6}},
                                                {11.8, {0.70, 0.00, 1.20, 360, 10, 0}},
                                                {12.8, {0.35, 0.00, 1.05, 360, 35, 0}},
                                                {13.6, {0.05, 0.00, 0.75, 360, 60, 0}},
                                                {14.8, {0.00, 0.00, kOnFloor + 0.01, 360, 90, 0}},
                                                {kBoardLaidSeconds, {0.00, 0.00, kOnFloor, 360, 90, 0}}}};

}  // namespace

Eigen::Isometry3d board_pose(double seconds) {
  const auto [x, y, z, facing, tilt, roll] = curve_at<6>(kPath, seconds);
  Eigen::Matrix3d upright;  // face to +x: right is +y, up is +z
  upright << Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX();
  Eigen::Isometry3d world_from_board(Eigen::Translation3d(x, y, z));
  world_from_board.linear() =
      (AngleAxisd(facing * kDegree, Vector3d::UnitZ()) * AngleAxisd(-tilt * kDegree, Vector3d::UnitY()) *
       AngleAxisd(roll * kDegree, Vector3d::UnitX()))
          .toRotationMatrix() *
      upright;
  return world_from_board;
}

}  // namespace rotunda::simulator
