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
// tilted upwards, its roll. Into each corner of the volume, up and down there, then back to the
// middle: the lower edge is set down, the upper one laid towards the carrier.
constexpr std::array<CurveKey<6>, 32> kPath = {
    {{0.0, {0.44, 0.00, 1.12, 0, 0, 0}},        {0.3, {0.44, 0.00, 1.12, 0, 0, 0}},
     {2.1, {1.34, -0.61, 1.15, 0, 6, 0}},       {3.4, {1.38, -0.62, 0.36, 0, 14, -3}},
     {3.6, {1.38, -0.62, 0.36, 0, 14, -3}},     {5.2, {1.38, -0.62, 1.62, 0, -20, 4}},
     {5.4, {1.38, -0.62, 1.62, 0, -20, 4}},     {6.7, {1.08, -0.14, 1.25, 72, 5, 0}},
     {7.7, {1.11, 0.45, 1.38, 90, -8, -8}},     {8.9, {1.12, 0.88, 1.59, 90, -20, 0}},
     {9.1, {1.12, 0.88, 1.59, 90, -20, 0}},     {10.6, {1.12, 0.885, 0.36, 90, 14, 3}},
     {10.8, {1.12, 0.885, 0.36, 90, 14, 3}},    {12.3, {0.62, 0.54, 1.15, 165, 10, 0}},
     {13.5, {-0.22, 0.60, 1.30, 180, -10, 10}}, {14.9, {-1.24, 0.62, 1.40, 180, -15, 4}},
     {15.7, {-1.38, 0.62, 1.62, 180, -20, 0}},  {15.9, {-1.38, 0.62, 1.62, 180, -20, 0}},
     {17.5, {-1.38, 0.62, 0.36, 180, 14, 3}},   {17.7, {-1.38, 0.62, 0.36, 180, 14, 3}},
     {19.2, {-1.02, 0.12, 1.12, 252, 12, 0}},   {20.2, {-1.12, -0.50, 1.35, 270, -6, -8}},
     {21.3, {-1.12, -0.88, 1.59, 270, -20, 0}}, {21.5, {-1.12, -0.88, 1.59, 270, -20, 0}},
     {23.1, {-1.12, -0.885, 0.36, 270, 14, 0}}, {23.3, {-1.12, -0.885, 0.36, 270, 14, 0}},
     {25.1, {-0.58, -0.33, 1.13, 335, 14, 0}},  {26.8, {-0.02, 0.00, 1.05, 360, 30, 0}},
     {28.4, {0.11, 0.00, 0.238, 360, 22, 0}},  {28.9, {0.05, 0.00, 0.187, 360, 45, 0}},
     {29.4, {0.012, 0.00, 0.101, 360, 70, 0}},  {kBoardLaidSeconds, {0.00, 0.00, kOnFloor, 360, 90, 0}}}};

}  // namespace

double board_facing(double seconds) {
  return curve_at<6>(kPath, seconds)[3];
}

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
