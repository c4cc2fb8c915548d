#include "recon/sphere/spherical_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;

TEST(Orientation, IsTheSignOfTheDeterminant) {
  EXPECT_EQ(orientation(Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()), 1);
  EXPECT_EQ(orientation(Vector3d::UnitY(), Vector3d::UnitX(), Vector3d::UnitZ()), -1);
  EXPECT_EQ(orientation(Vector3d::UnitX(), Vector3d::UnitY(), Vector3d(1, 1, 0)), 0);
}

// det(p, q, p + 2^e q + 2^-s w) = 2^-s det(p, q, w) exactly, with every sum exact in a double: far below the rounding
// error of the plain determinant, whose terms are near 1.
TEST(Orientation, IsExactWhereRoundingErrorIsLargerThanTheDeterminant) {
  const double tiny = std::ldexp(1.0, -50);
  const Vector3d p(1.0, 0.5, 0.25), q(0.75, -1.0, 0.5);
  for (const double side : {-1.0, 0.0, 1.0}) {
    const Vector3d r = p + q + Vector3d(0.0, 0.0, side * tiny);
    EXPECT_EQ(orientation(p, q, r), -static_cast<int>(side));  // det(p, q, e_z) = -1 - 0.375 < 0
    EXPECT_EQ(orientation(q, r, p), -static_cast<int>(side));
    EXPECT_EQ(orientation(q, p, r), static_cast<int>(side));
  }
}

// With 21-bit integers every product fits a 128-bit integer, which gives the truth.
TEST(Orientation, AgreesWithIntegerArithmeticOnNearlyFlatTriples) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<long> coordinate(-(1L << 40), 1L << 40), nudge(-1, 1), factor(-3, 3);
  int flat = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    long v[3][3];
    const long a = factor(random), b = factor(random);
    for (int i = 0; i < 3; ++i) {
      v[0][i] = coordinate(random);
      v[1][i] = coordinate(random);
      v[2][i] = a * v[0][i] + b * v[1][i] + nudge(random) * (i == trial % 3);
    }
    __extension__ using Wide = __int128;
    Wide truth = 0;  // |det| < 6 * 2^(40 + 40 + 43) < 2^127
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      truth += Wide(v[0][i]) * v[1][j] * v[2][k] - Wide(v[0][i]) * v[1][k] * v[2][j];
    }
    const auto point = [&](int i) { return Vector3d(double(v[i][0]), double(v[i][1]), double(v[i][2])); };
    flat += truth == 0;
    ASSERT_EQ(orientation(point(0), point(1), point(2)), truth > 0 ? 1 : (truth < 0 ? -1 : 0));
  }
  EXPECT_GT(flat, 100);  // the cases that matter did occur
}

TEST(SphericalArea, IsThatOfAnOctantAndOfASliver) {
  EXPECT_NEAR(spherical_area(Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()), std::numbers::pi / 2.0, 1e-15);
  // A sliver of width w over the base b: area b w / 2 to first order.
  const double width = 1e-9, base = 1e-3;
  const Vector3d p = Vector3d::UnitX(), q = Vector3d(1.0, base, 0.0).normalized(),
                 r = Vector3d(1.0, base / 2.0, width).normalized();
  EXPECT_NEAR(spherical_area(p, q, r) / (0.5 * base * width), 1.0, 1e-5);
  EXPECT_LT(spherical_area(q, p, r), 0.0);
}

TEST(RingKernel, OfARegularRingHoldsItsCentre) {
  std::vector<Vector3d> ring;
  for (int i = 0; i < 6; ++i) {
    const double turn = std::numbers::pi * i / 3.0;
    ring.push_back(Vector3d(0.01 * std::cos(turn), 0.01 * std::sin(turn), 1.0).normalized());
  }
  const auto point = kernel_point(ring, ring[0]);
  ASSERT_TRUE(point);
  EXPECT_NEAR((*point - Vector3d::UnitZ()).norm(), 0.0, 1e-6);
}

// A dart whose reflex corner leaves a kernel only between the two edges that meet there, drawn ever thinner.
TEST(RingKernel, IsFoundInThinDarts) {
  for (const double reflex : {1e-3, 1e-6, 1e-9}) {
    const auto on_sphere = [](double x, double y) { return Vector3d(0.01 * x, 0.01 * y, 1.0).normalized(); };
    const std::vector<Vector3d> dart = {on_sphere(0, 1), on_sphere(-1, -1), on_sphere(0, 1 - reflex), on_sphere(1, -1)};
    const auto point = kernel_point(dart, dart[0]);
    ASSERT_TRUE(point) << reflex;
    EXPECT_TRUE(inside_kernel(*point, dart));
  }
}

TEST(RingKernel, IsEmptyForARingThatNoPointSees) {
  const auto on_sphere = [](double x, double y) { return Vector3d(0.1 * x, 0.1 * y, 1.0).normalized(); };
  // A thin horseshoe.
  const std::vector<Vector3d> ring = {on_sphere(-2, 0),   on_sphere(2, 0),     on_sphere(2, 3),    on_sphere(1.9, 3),
                                      on_sphere(1.9, .1), on_sphere(-1.9, .1), on_sphere(-1.9, 3), on_sphere(-2, 3)};
  EXPECT_FALSE(kernel_point(ring, Vector3d::UnitZ()));
}

}  // namespace
}  // namespace rotunda::recon
