#include "recon/sphere/resample.h"

#include <gtest/gtest.h>

#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/relaxed_lattice.h"
#include "recon/sphere/spherical_geometry.h"
#include "tests/support/closed_shapes.h"
#include "tests/support/surface_distance.h"

namespace rotunda::recon {
namespace {

class ResampledStarfish : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    mesh_ = tests::starfish(3);
    compute_normals(mesh_);
    map_ = map_to_sphere(mesh_).map.value();
  }
  inline static TriangleMesh mesh_;
  inline static SphereMap map_;
};

TEST_F(ResampledStarfish, EverySampleLiesInTheTriangleFoundForIt) {
  const auto directions = lattice_directions(5);
  const auto samples = sample_lattice(mesh_, map_, directions);
  ASSERT_EQ(samples.size(), directions.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& t = mesh_.triangles[samples[i].triangle];
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_GE(orientation(directions[i], map_.points[t[k]], map_.points[t[(k + 1) % 3]]), 0);
    const auto& b = samples[i].barycentric;
    ASSERT_NEAR(b.sum(), 1.0, 1e-12);
    const Eigen::Vector3d back = b[0] * map_.points[t[0]] + b[1] * map_.points[t[1]] + b[2] * map_.points[t[2]];
    ASSERT_LT((back.normalized() - directions[i]).norm(), 1e-9);
  }
}

TEST_F(ResampledStarfish, BorderSamplesAreBitwiseEqual) {
  const auto image = resample(mesh_, map_, 5);
  const auto side = static_cast<std::size_t>(image.side()), last = side - 1;
  for (std::size_t i = 0; i < side; ++i)
    for (const auto& [a, b] : {std::pair{i, last - i},
                               {last * side + i, last * side + last - i},
                               {i * side, (last - i) * side},
                               {i * side + last, (last - i) * side + last}}) {
      EXPECT_EQ(image.positions[a], image.positions[b]);
      EXPECT_EQ(image.normals[a], image.normals[b]);
    }
}

TEST_F(ResampledStarfish, RemeshIsAClosedSphereOnTheSameSurface) {
  const auto remeshed = remesh(resample(mesh_, map_, 7));
  EXPECT_TRUE(topology_of(remeshed).is_sphere());
  EXPECT_NEAR(signed_volume(remeshed) / signed_volume(mesh_), 1.0, 0.01);
}

TEST_F(ResampledStarfish, ErrorFallsFasterThanTheSampleDistance) {
  const auto error = [&](int level) {
    return tests::symmetric_distance(mesh_, remesh(resample(mesh_, map_, level)), 1000).mean;
  };
  EXPECT_LT(error(7), error(5) / 4.0);  // between first and second order: edges of the mesh are cut, faces are exact
}

TEST_F(ResampledStarfish, ColourPointsAreTheFinerLatticeOfTheSameSurface) {
  const auto lattice = relaxed_lattice(mesh_, map_, 4);
  const auto coarse = surface_points(mesh_, map_, lattice);
  const auto points = surface_points(mesh_, map_, refine_directions(lattice, 5));
  const std::size_t side = 17, fine_side = 33;
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x)
      EXPECT_LT((points.positions[2 * y * fine_side + 2 * x] - coarse.positions[y * side + x]).norm(), 1e-5F);
}

TEST_F(ResampledStarfish, RemeshOfEveryLevelIsAClosedSphereWhicheverWayItsCellsAreCut) {
  for (int level = 1; level <= 5; ++level) {
    const auto remeshed = remesh(resample(mesh_, map_, level));
    EXPECT_TRUE(topology_of(remeshed).is_sphere()) << "level " << level;
  }
}

TEST(FittedLattice, NeitherShrinksABallNorLeavesItsSurfaceFarther) {
  auto ball = tests::icosphere(4);
  SphereMap map;
  for (const auto& p : ball.positions) map.points.push_back(p.cast<double>().normalized());
  const auto directions = lattice_directions(4);
  const auto fitted = remesh(resample(ball, map, directions));
  auto sampled = fitted;
  const auto points = surface_points(ball, map, directions);
  const auto lattice = weld_lattice(4);
  for (std::size_t v = 0; v < sampled.positions.size(); ++v)
    sampled.positions[v] = points.positions[lattice.sample_of_vertex[v]];
  const double volume = signed_volume(ball);
  EXPECT_LT(std::abs(signed_volume(fitted) - volume), 0.5 * std::abs(signed_volume(sampled) - volume));
  EXPECT_LT(tests::symmetric_distance(ball, fitted, 5000).max, tests::symmetric_distance(ball, sampled, 5000).max);
}

TEST_F(ResampledStarfish, RefusesDirectionsThatAreNoLattice) {
  EXPECT_THROW(resample(mesh_, map_, std::vector<Eigen::Vector3d>(26, Eigen::Vector3d::UnitX())), InvalidInput);
}

TEST_F(ResampledStarfish, RefusesAMapOfAnotherMesh) {
  EXPECT_THROW(resample(tests::icosphere(1), map_, 5), InvalidInput);
  EXPECT_THROW(resample(mesh_, map_, 0), InvalidInput);
}

GeometryImage coloured(int level) {
  GeometryImage image;
  image.level = image.colour_level = level;
  image.colours.assign(lattice_size(level), {200, 100, 50});
  image.coverage.assign(lattice_size(level), 255);
  return image;
}

TEST(FillUnseen, KeepsSeenTexelsAndAConstantColour) {
  auto image = coloured(6);
  for (std::size_t i = 0; i < image.coverage.size(); ++i)
    if (i % 7 != 3) {
      image.coverage[i] = 0;
      image.colours[i] = {0, 0, 0};
    }
  const auto coverage = image.coverage;
  fill_unseen(image);
  for (const auto& colour : image.colours) ASSERT_EQ(colour, (Colour{200, 100, 50}));
  EXPECT_EQ(image.coverage, coverage);
}

// The hole lies on the left border's upper half; the same points of the sphere lie on its lower half.
TEST(FillUnseen, IsContinuousAcrossTheBorder) {
  auto image = coloured(6);
  const auto side = static_cast<std::size_t>(image.colour_side());
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const bool unseen = x < 12 && (y < 26 && y > 6);
      image.colours[y * side + x] = unseen ? Colour{0, 0, 0} : (y < side / 2 ? Colour{0, 0, 0} : Colour{240, 240, 240});
      image.coverage[y * side + x] = unseen ? 0 : 255;
    }
  for (std::size_t y = 0; y <= side / 2; ++y)  // border samples are seen or unseen on both halves
    image.coverage[(side - 1 - y) * side] = image.coverage[y * side];
  fill_unseen(image);
  for (std::size_t y = 7; y < 26; ++y) {
    EXPECT_EQ(image.colours[y * side], image.colours[(side - 1 - y) * side]);
    EXPECT_GT(image.colours[y * side][0], 60);  // drawn from the bright side beyond the border
  }
}

TEST(FillUnseen, RefusesAnImageWithoutColours) {
  GeometryImage image;
  EXPECT_THROW(fill_unseen(image), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
