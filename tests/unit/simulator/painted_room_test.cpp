#include "simulator/studio/painted_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

const Vector3d kEye(3.6, 0.0, 1.3);

// Blue light of the floor about the stage and of the wall above it, in rays that pass no lamp.
std::vector<float> blue_around(const BackdropOptions& options) {
  const PaintedRoom room(options);
  std::vector<float> blue;
  for (double azimuth = 2.2; azimuth < 4.1; azimuth += 0.1)
    for (double slope = -0.9; slope < 0.15; slope += 0.05)
      blue.push_back(
          room.seen_along(kEye, Vector3d(std::cos(azimuth), std::sin(azimuth), slope).normalized(), 0.001).linear.z());
  std::sort(blue.begin(), blue.end());
  return blue;
}

TEST(PaintedRoom, IsLitAsUnevenlyAsAskedAndEvenlyIfAsked) {
  const auto spread = [](double unevenness) {
    const auto blue = blue_around({.unevenness = unevenness, .wear = 0.0, .gloss = 0.0});
    return blue[blue.size() * 97 / 100] / blue[blue.size() * 3 / 100];
  };
  EXPECT_NEAR(spread(1.0), 1.0F, 0.01F);
  EXPECT_GT(spread(2.0), 1.25F);
  EXPECT_LT(spread(2.0), 2.2F);
  EXPECT_GT(spread(4.0), spread(2.0) + 0.3F);
}

TEST(PaintedRoom, IsBlueWherePeopleLookAndDarkBeyondTheWallsEdge) {
  const PaintedRoom room({});
  for (const double slope : {-0.5, -0.2, 0.1}) {
    const auto seen = room.seen_along(kEye, Vector3d(-1.0, 0.1, slope).normalized(), 0.001).linear;
    EXPECT_GT(seen.z(), 2.0F * seen.y());
    EXPECT_GT(seen.y(), seen.x());
  }
  const auto beyond = room.seen_along(kEye, Vector3d(-1.0, 0.0, 0.36).normalized(), 0.001);
  EXPECT_GT(beyond.point.z(), BackdropOptions{}.wall_height);
  EXPECT_LT(beyond.linear.z(), 0.03F);
}

TEST(PaintedRoom, IsGreenIfAsked) {
  const PaintedRoom room({.paint = ScreenPaint::green});
  const auto seen = room.seen_along(kEye, Vector3d(-1.0, 0.1, -0.3).normalized(), 0.001).linear;
  EXPECT_GT(seen.y(), 2.0F * seen.z());
  EXPECT_GT(seen.z(), seen.x());
}

TEST(PaintedRoom, WearIsOfTheSeedAndCanBeSwitchedOff) {
  const auto differ = [](const BackdropOptions& a, const BackdropOptions& b) {
    const PaintedRoom one(a), other(b);
    double most = 0.0;
    for (double y = -1.5; y < 1.5; y += 0.017) {
      const Vector3d ray = (Vector3d(-0.4, y, 0.0) - kEye).normalized();
      const auto first = one.seen_along(kEye, ray, 0.001).linear, second = other.seen_along(kEye, ray, 0.001).linear;
      most = std::max(most, static_cast<double>((first - second).cwiseAbs().maxCoeff()));
    }
    return most;
  };
  const BackdropOptions used{.unevenness = 1.0, .seed = 5}, again = used;
  EXPECT_EQ(differ(used, again), 0.0);
  EXPECT_GT(differ(used, {.unevenness = 1.0, .seed = 6}), 0.01);
  EXPECT_LT(differ({.unevenness = 1.0, .wear = 0.0, .seed = 5}, {.unevenness = 1.0, .wear = 0.0, .seed = 6}), 1e-6);
}

}  // namespace
}  // namespace rotunda::simulator
