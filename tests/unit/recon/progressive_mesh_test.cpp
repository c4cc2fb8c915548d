#include "recon/sphere/progressive_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "config/errors.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::recon {
namespace {

// Triangles by fine vertices, each turned to start at its lowest, sorted.
std::vector<std::array<std::uint32_t, 3>> sorted_triangles(std::vector<std::array<std::uint32_t, 3>> triangles) {
  for (auto& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(ProgressiveMesh, RefinedToTheEndIsTheMeshItCameFrom) {
  const auto mesh = tests::starfish(3);
  const auto progressive = simplify_to_tetrahedron(mesh);
  RefiningMesh refining(progressive);
  while (!refining.done()) refining.split();
  auto triangles = refining.triangles();
  for (auto& t : triangles)
    for (auto& v : t) v = progressive.fine_vertex[v];
  EXPECT_EQ(sorted_triangles(triangles), sorted_triangles(mesh.triangles));
}

TEST(ProgressiveMesh, EveryLevelIsAClosedSphere) {
  const auto mesh = tests::starfish(2);
  const auto progressive = simplify_to_tetrahedron(mesh);
  for (std::size_t count = 4; count <= mesh.positions.size(); ++count) {
    const auto level = level_of(progressive, mesh, count);
    ASSERT_EQ(level.positions.size(), count);
    ASSERT_TRUE(topology_of(level).is_sphere()) << count << " vertices";
  }
  EXPECT_THROW(level_of(progressive, mesh, 3), InvalidInput);
  EXPECT_THROW(level_of(progressive, mesh, mesh.positions.size() + 1), InvalidInput);
}

TEST(ProgressiveMesh, CoarseVerticesStandForAllFineVerticesAtEveryLevel) {
  const auto mesh = tests::starfish(3);
  const auto progressive = simplify_to_tetrahedron(mesh);
  RefiningMesh refining(progressive);
  while (true) {
    std::size_t sum = 0;
    for (std::uint32_t v = 0; v < refining.vertex_count(); ++v) {
      ASSERT_GE(refining.fine_count(v), 1U);
      sum += refining.fine_count(v);
    }
    ASSERT_EQ(sum, mesh.positions.size());
    if (refining.done()) break;
    refining.split();
  }
}

TEST(ProgressiveMesh, FlatPartsGoFirstAndTipsOfLimbsLast) {
  const auto mesh = tests::starfish(4);
  const auto progressive = simplify_to_tetrahedron(mesh);
  const auto level = level_of(progressive, mesh, 60);
  // The five tips lie more than 1.1 m from the centre; each keeps a vertex among the last 60 of 2562.
  std::array<bool, 5> tip = {};
  for (const auto& p : level.positions) {
    if (std::hypot(p.x(), p.y()) < 1.0F) continue;
    const double turn = std::atan2(p.y(), p.x()) / (2.0 * std::numbers::pi) * 5.0;
    tip[static_cast<std::size_t>(std::lround(turn + 5.0)) % 5] = true;
  }
  EXPECT_EQ(tip, (std::array<bool, 5>{true, true, true, true, true}));
}

TEST(ProgressiveMesh, RefusesWhatIsNoSphere) {
  EXPECT_THROW(simplify_to_tetrahedron(tests::torus()), InvalidInput);
  auto open = tests::icosphere(1);
  open.triangles.pop_back();
  EXPECT_THROW(simplify_to_tetrahedron(open), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
