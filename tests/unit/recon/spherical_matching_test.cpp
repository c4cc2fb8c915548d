#include "recon/sphere/spherical_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;

// A body of about a person's size that looks the same from no two sides: a tall ellipsoid with a thick end, a bump and
// patches of colour.
Vector3d place_of(const Vector3d& d) {
  const double bump = 0.10 * std::exp(-8.0 * (d - Vector3d(0.8, 0.6, 0.0)).squaredNorm());
  const double thick = 1.0 + 0.5 * d.z();
  return Vector3d(0.30 * thick * d.x(), 0.20 * thick * d.y(), 0.85 * d.z()) + bump * d;
}

Colour colour_of(const Vector3d& d) {
  const auto part = [](double wave) { return static_cast<std::uint8_t>(std::lround(127.5 + 120.0 * std::sin(wave))); };
  return {part(3.0 * d.x() + 1.0), part(4.0 * d.y()), part(5.0 * d.z() + 0.5)};
}

// The body sampled where the directions say, moved as a whole.
template <class Warp>
GeometryImage image_of(int level, const Warp& warp, const Vector3d& shift = Vector3d::Zero()) {
  GeometryImage image{.level = level, .colour_level = level};
  constexpr double kStep = 1e-4;
  for (const auto& direction : lattice_directions(level)) {
    const Vector3d d = warp(direction).normalized();
    const TangentFrame frame(d);
    const Vector3d normal = (place_of(d + kStep * frame.u) - place_of(d - kStep * frame.u))
                                .cross(place_of(d + kStep * frame.v) - place_of(d - kStep * frame.v));
    image.positions.push_back((place_of(d) + shift).cast<float>());
    image.normals.push_back(normal.normalized().cast<float>());
    image.colours.push_back(colour_of(d));
  }
  image.coverage.assign(image.colours.size(), 255);
  return image;
}

Vector3d as_it_is(const Vector3d& d) {
  return d;
}

double mean_distance(const GeometryImage& a, const GeometryImage& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    sum += static_cast<double>((a.positions[i] - b.positions[i]).norm());
  return sum / static_cast<double>(a.positions.size());
}

constexpr int kLevel = 5;

TEST(SphericalMatching, FindsTheRotationThatASurfaceWasSampledWith) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const auto to = image_of(kLevel, as_it_is);
  const auto from = image_of(kLevel, [&](const Vector3d& d) -> Vector3d { return turn * d; }, {0.4, -1.0, 0.2});
  const auto match = match_on_sphere(from, to);
  // Sample d of `from` shows what direction turn * d of `to` shows.
  EXPECT_LT(Eigen::AngleAxisd(match.rotation * turn.transpose()).angle(), 0.1);
  auto matched = matched_image(from, match);
  for (auto& position : matched.positions) position -= Eigen::Vector3f(0.4F, -1.0F, 0.2F);
  EXPECT_GT(mean_distance(from, to), 0.5);
  EXPECT_LT(mean_distance(matched, to), 0.012);  // samples are 40 mm apart
  EXPECT_EQ(match.folds, 0U);
}

TEST(SphericalMatching, FollowsASurfaceThatSlidUnderItsSamples) {
  const auto slide = [](const Vector3d& d) -> Vector3d {
    return d + 0.25 * Vector3d(std::sin(3.0 * d.z()), std::sin(3.0 * d.x()), 0.0);
  };
  constexpr int kFine = 6;  // a coarse lattice cannot follow as closely
  const auto to = image_of(kFine, as_it_is), from = image_of(kFine, slide);
  const auto match = match_on_sphere(from, to);
  const double before = mean_distance(from, to), after = mean_distance(matched_image(from, match), to);
  EXPECT_GT(before, 0.05);
  EXPECT_LT(after, 0.25 * before);
  EXPECT_EQ(match.folds, 0U);
  ASSERT_EQ(match.levels.size(), static_cast<std::size_t>(kFine));
  for (const auto& level : match.levels) EXPECT_GT(level.updates, 0);
}

TEST(SphericalMatching, TakesTheColoursAlong) {
  const auto slide = [](const Vector3d& d) -> Vector3d { return d + 0.2 * Vector3d(std::sin(3.0 * d.z()), 0.0, 0.0); };
  const auto to = image_of(kLevel, as_it_is), from = image_of(kLevel, slide);
  const auto matched = matched_image(from, match_on_sphere(from, to));
  const auto difference = [&](const GeometryImage& image) {
    double sum = 0.0;
    for (std::size_t i = 0; i < to.colours.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) sum += std::abs(image.colours[i][c] - to.colours[i][c]);
    return sum / static_cast<double>(3 * to.colours.size());
  };
  EXPECT_LT(difference(matched), 0.4 * difference(from));
  EXPECT_EQ(matched.coverage.size(), from.coverage.size());
}

// What has nothing in common pulls samples anywhere; none may leave the kernel of its ring.
TEST(SphericalMatching, StaysOneToOneWhateverItIsGiven) {
  std::mt19937 random(7);
  std::normal_distribution<float> anywhere(0.0F, 0.5F);
  auto from = image_of(4, as_it_is), to = from;
  for (auto* image : {&from, &to})
    for (std::size_t i = 0; i < image->positions.size(); ++i) {
      image->positions[i] = Eigen::Vector3f(anywhere(random), anywhere(random), anywhere(random));
      image->normals[i] = Eigen::Vector3f(anywhere(random), anywhere(random), anywhere(random)).normalized();
    }
  for (const double regularity : {0.75, 0.1})
    EXPECT_EQ(match_on_sphere(from, to, {.regularity = regularity}).folds, 0U);
}

TEST(SphericalMatching, DoesNotDependOnThreads) {
  const auto slide = [](const Vector3d& d) -> Vector3d { return d + 0.2 * Vector3d(0.0, std::sin(3.0 * d.z()), 0.0); };
  const auto to = image_of(4, as_it_is), from = image_of(4, slide);
  const auto many = match_on_sphere(from, to);
  tbb::task_arena alone(1);
  alone.execute([&] { EXPECT_EQ(match_on_sphere(from, to).directions, many.directions); });
}

TEST(SphericalMatching, OneByOneComesToTheSame) {
  const auto slide = [](const Vector3d& d) -> Vector3d { return d + 0.2 * Vector3d(0.0, std::sin(3.0 * d.z()), 0.0); };
  const auto to = image_of(4, as_it_is), from = image_of(4, slide);
  const auto sets = matched_image(from, match_on_sphere(from, to)),
             one = matched_image(from, match_on_sphere(from, to, {.one_by_one = true}));
  EXPECT_LT(mean_distance(sets, one), 0.005);
}

TEST(SphericalMatching, RefusesWhatItCannotCompare) {
  const auto fine = image_of(4, as_it_is), coarse = image_of(3, as_it_is);
  EXPECT_THROW(match_on_sphere(fine, coarse), InvalidInput);
  auto bare = fine;
  bare.colours.clear();
  EXPECT_THROW(match_on_sphere(fine, bare), InvalidInput);
  EXPECT_THROW(matched_image(coarse, match_on_sphere(fine, fine)), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
