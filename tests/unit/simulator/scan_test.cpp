#include "simulator/scan/scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "config/errors.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/scan/body_scanner.h"
#include "tests/support/closed_shapes.h"
#include "tests/support/surface_distance.h"

namespace rotunda::simulator {
namespace {

using recon::TriangleMesh;

// As tall as a person, standing: from four sides nobody sees its sole and crown.
TriangleMesh surface() {
  auto mesh = tests::icosphere(5);
  for (auto& p : mesh.positions) p = Eigen::Vector3f(0.25F * p.x(), 0.20F * p.y(), 0.9F + 0.85F * p.z());
  recon::compute_normals(mesh);
  return mesh;
}
Eigen::Vector3d paint(const Eigen::Vector3d& p) {
  return {0.5 + p.x(), 0.5 + p.y(), 0.2 + 0.4 * p.z()};
}
SurfaceTexture texture() {
  return paint_surface(surface(), 4, [](std::size_t, const Eigen::Vector3d& p) { return paint(p); });
}
TriangleMesh scan(const ScanOptions& options) {
  return scan_of(surface(), texture(), options);
}

double mean_distance(const TriangleMesh& from, const TriangleMesh& to) {
  const tests::DistanceTree tree(to);
  double sum = 0.0;
  for (std::size_t v = 0; v < from.positions.size(); v += 7) sum += tree.distance(from.positions[v].cast<double>());
  return sum / (static_cast<double>(from.positions.size()) / 7.0);
}

TEST(Scan, HasTheTrianglesAskedForOnTheTrueSurface) {
  const auto truth = surface();
  const tests::DistanceTree tree(truth);
  const auto before = recon::topology_of(truth);
  for (const std::size_t triangles : {truth.triangles.size() / 2, 3 * truth.triangles.size() / 2 * 2}) {
    const auto mesh = scan({.triangles = triangles});
    EXPECT_LE(mesh.triangles.size(), triangles);
    EXPECT_GE(mesh.triangles.size() + 2, triangles);
    const auto topology = recon::topology_of(mesh);
    EXPECT_TRUE(topology.manifold);
    EXPECT_EQ(topology.euler_characteristic, before.euler_characteristic);
    double worst = 0.0;
    for (std::size_t v = 0; v < mesh.positions.size(); v += 5)
      worst = std::max(worst, tree.distance(mesh.positions[v].cast<double>()));
    EXPECT_LT(worst, 1e-6);  // what float positions leave
  }
}

TEST(Scan, ItsTrianglesAreEven) {
  const auto mesh = scan({.triangles = 5 * surface().triangles.size()});
  std::vector<double> areas;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d { return mesh.positions[t[i]].cast<double>(); };
    areas.push_back((corner(1) - corner(0)).cross(corner(2) - corner(0)).norm());
  }
  std::sort(areas.begin(), areas.end());
  const double mean = 2.0 * recon::surface_area(mesh) / static_cast<double>(areas.size());
  EXPECT_LT(areas[areas.size() * 99 / 100], 3.0 * mean);
}

TEST(Scan, ColoursAreTheTextures) {
  const auto mesh = scan({.triangles = 50'000});
  ASSERT_EQ(mesh.colours.size(), mesh.positions.size());
  double worst = 0.0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Eigen::Vector3d wanted = 255.0 * paint(mesh.positions[v].cast<double>());
    for (std::size_t c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(mesh.colours[v][c] - wanted[static_cast<Eigen::Index>(c)]));
  }
  EXPECT_LT(worst, 2.0);  // texels and colours are whole numbers
}

TEST(Scan, NoiseMovesVerticesAMillimetreAndTearsNothing) {
  const ScanOptions options{.triangles = surface().triangles.size(), .flaws = scan_flaws_from("noise")};
  const auto mesh = scan(options);
  EXPECT_EQ(mesh.triangles.size(), options.triangles);
  EXPECT_TRUE(recon::topology_of(mesh).manifold);
  const double off = mean_distance(mesh, surface());
  EXPECT_GT(off, 0.0002);
  EXPECT_LT(off, 0.0015);
  EXPECT_EQ(scan(options).positions, mesh.positions);
  EXPECT_NE(scan({.triangles = options.triangles, .flaws = options.flaws, .seed = 2}).positions, mesh.positions);
}

TEST(Scan, HolesAreWhereNoColumnSees) {
  const auto truth = surface();
  const std::size_t asked = 2 * truth.triangles.size();
  const auto mesh = scan({.triangles = asked, .flaws = scan_flaws_from("holes")});
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), static_cast<double>(asked),
              0.006 * static_cast<double>(asked));
  EXPECT_FALSE(recon::topology_of(mesh).closed);
  EXPECT_LT(recon::surface_area(mesh), 0.995 * recon::surface_area(truth));
  EXPECT_GT(recon::surface_area(mesh), 0.60 * recon::surface_area(truth));
  const auto facing_down = [](const TriangleMesh& m) {
    return std::count_if(m.normals.begin(), m.normals.end(), [](const auto& n) { return n.z() < -0.9F; });
  };
  EXPECT_GT(facing_down(truth), 20);
  EXPECT_EQ(facing_down(mesh), 0);
}

TEST(Scan, PartialsOverlapAndAreMisaligned) {
  constexpr std::size_t kFew = 5000;
  const auto truth = surface();
  const auto mesh = scan({.triangles = kFew, .flaws = scan_flaws_from("holes,misaligned-partials")});
  const auto topology = recon::topology_of(mesh);
  EXPECT_GE(topology.components, kScannerColumns);
  EXPECT_FALSE(topology.closed);
  const double off = mean_distance(mesh, truth);
  EXPECT_GT(off, 0.0003);
  EXPECT_LT(off, 0.006);
  EXPECT_GT(recon::surface_area(mesh),
            1.05 * recon::surface_area(scan({.triangles = kFew, .flaws = scan_flaws_from("holes")})));
  const auto file = testing::TempDir() + "partials.ply";
  recon::write_ply(file, mesh);  // takes manifold pieces only
  EXPECT_EQ(recon::read_ply(file).triangles.size(), mesh.triangles.size());
}

TEST(Scan, RefusesWhatScannersDoNotHave) {
  EXPECT_THROW(scan_flaws_from("noise,dust"), InvalidInput);
  EXPECT_THROW(scan({.triangles = 0}), InvalidInput);
  auto of_another = texture();
  of_another.corners.pop_back();
  EXPECT_THROW(scan_of(surface(), of_another), InvalidInput);
}

}  // namespace
}  // namespace rotunda::simulator
