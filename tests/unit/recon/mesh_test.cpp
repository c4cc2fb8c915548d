// Claims about recon/mesh: what a mesh is, files, smoothing, simplification.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <thread>

#include "config/errors.h"
#include "recon/hull/marching_cubes.h"
#include "recon/mesh/mesh_file.h"
#include "recon/mesh/simplify.h"
#include "recon/mesh/smoothing.h"
#include "recon/mesh/triangle_mesh.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TriangleMesh surface_of(const tests::CapsuleBody& body, double half, double cell) {
  const int blocks = static_cast<int>(std::ceil(2.0 * half / (cell * SignedGrid::kSide)));
  std::vector<Eigen::Vector3i> all;
  for (int i = 0; i < blocks * blocks * blocks; ++i)
    all.emplace_back(i % blocks, i / blocks % blocks, i / blocks / blocks);
  SignedGrid grid(Eigen::Vector3d::Constant(-half), cell, static_cast<float>(-3.0 * cell), all);
  for (VoxelId id = 0; id < grid.voxel_count(); ++id)
    grid.set_value(id, static_cast<float>(tests::signed_distance(body, grid.position(id))));
  return marching_cubes(grid);
}

struct TemporaryFolder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("rotunda_mesh_test_" + std::to_string(::getpid()));
  TemporaryFolder() { std::filesystem::create_directories(path); }
  ~TemporaryFolder() { std::filesystem::remove_all(path); }
};

TEST(TriangleMesh, TellsAClosedSphereFromOpenTurnedAndPinchedSurfaces) {
  auto mesh = tetrahedron();
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  EXPECT_NEAR(signed_volume(mesh), 1.0 / 6.0, 1e-9);
  EXPECT_NEAR(surface_area(mesh), 1.5 + std::sqrt(3.0) / 2.0, 1e-6);
  auto open = mesh;
  open.triangles.pop_back();
  EXPECT_FALSE(topology_of(open).closed);
  auto turned = mesh;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_FALSE(topology_of(turned).closed);
  auto pinched = mesh;  // two tetrahedra that share a vertex
  pinched.positions.insert(pinched.positions.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  for (const auto& t : tetrahedron().triangles)
    pinched.triangles.push_back({t[0] == 0 ? 0 : t[0] + 3, t[2] == 0 ? 0 : t[2] + 3, t[1] == 0 ? 0 : t[1] + 3});
  EXPECT_TRUE(topology_of(pinched).closed);
  EXPECT_FALSE(topology_of(pinched).manifold);
  EXPECT_FALSE(topology_of({}).is_sphere());
}

TEST(TriangleMesh, NormalsPointOutwards) {
  auto mesh = surface_of(tests::ball({0, 0, 0}, 0.1), 0.16, 0.02);
  compute_normals(mesh);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_GT(mesh.normals[v].dot(mesh.positions[v].normalized()), 0.95F);
}

TEST(MeshFile, BringsEverythingBack) {
  const TemporaryFolder folder;
  auto mesh = tetrahedron();
  compute_normals(mesh);
  mesh.colours = {{255, 0, 1}, {2, 128, 3}, {4, 5, 255}, {7, 8, 9}};
  write_ply(folder.path / "mesh.ply", mesh);
  const auto back = read_ply(folder.path / "mesh.ply");
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.normals, mesh.normals);
  EXPECT_EQ(back.colours, mesh.colours);
  EXPECT_EQ(back.triangles, mesh.triangles);
}

// Two files whose vertices have different sizes: a reader that mixed them up would give neither.
TEST(MeshFile, ManyThreadsReadAndWriteAtOnce) {
  const TemporaryFolder folder;
  auto plain = tetrahedron();
  auto coloured = plain;
  coloured.colours.assign(4, {10, 20, 30});
  compute_normals(coloured);
  std::vector<std::jthread> threads;
  std::array<int, 4> wrong{};
  for (std::size_t t = 0; t < wrong.size(); ++t)
    threads.emplace_back([&, t] {
      const auto& mesh = t % 2 == 0 ? plain : coloured;
      const auto file = folder.path / (std::to_string(t) + ".ply");
      for (int round = 0; round < 200; ++round) {
        write_ply(file, mesh);
        const auto back = read_ply(file);
        wrong[t] += back.positions != mesh.positions || back.colours != mesh.colours || back.triangles != mesh.triangles;
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

TEST(MeshFile, LeavesOutWhatTheMeshHasNot) {
  const TemporaryFolder folder;
  write_ply(folder.path / "mesh.ply", tetrahedron());
  const auto back = read_ply(folder.path / "mesh.ply");
  EXPECT_TRUE(back.normals.empty());
  EXPECT_TRUE(back.colours.empty());
  EXPECT_EQ(back.triangles, tetrahedron().triangles);
}

const char* const kAscii =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

TEST(MeshFile, ReadsTextAndCutsPolygonsIntoFans) {
  const TemporaryFolder folder;
  std::ofstream(folder.path / "square.ply") << kAscii;
  const auto mesh = read_ply(folder.path / "square.ply");
  ASSERT_EQ(mesh.triangles.size(), 2U);
  EXPECT_NEAR(surface_area(mesh), 1.0, 1e-6);
}

TEST(MeshFile, ReadsAnObjWithTextureAndRelativeIndices) {
  const TemporaryFolder folder;
  std::ofstream(folder.path / "square.OBJ") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 1\n"
                                               "f 1/1 2/2 3/1\nf -4/1 -2/2 -1/1\n";
  const auto mesh = read_mesh(folder.path / "square.OBJ");
  ASSERT_EQ(mesh.positions.size(), 4U);
  EXPECT_EQ(mesh.positions[3], Eigen::Vector3f(0.0F, 1.0F, 0.5F));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(MeshFile, RefusesAnObjWithoutFacesOrWithAVertexTooMany) {
  const TemporaryFolder folder;
  std::ofstream(folder.path / "points.obj") << "v 0 0 0\nv 1 0 0\n";
  EXPECT_THROW(read_mesh(folder.path / "points.obj"), CorruptData);
  std::ofstream(folder.path / "wild.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n";
  EXPECT_THROW(read_mesh(folder.path / "wild.obj"), CorruptData);
}

TEST(MeshFile, RefusesEveryTruncation) {
  const TemporaryFolder folder;
  auto mesh = tetrahedron();
  compute_normals(mesh);
  write_ply(folder.path / "mesh.ply", mesh);
  std::ifstream stream(folder.path / "mesh.ply", std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(folder.path / "cut.ply", std::ios::binary) << whole.substr(0, length);
    EXPECT_THROW(read_ply(folder.path / "cut.ply"), CorruptData) << length;
  }
}

TEST(MeshFile, RefusesPromisesAFileCannotKeep) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string text = kAscii;
    text.replace(text.find(what), what.size(), instead);
    std::ofstream(folder.path / "bad.ply") << text;
    return folder.path / "bad.ply";
  };
  EXPECT_THROW(read_ply(with("vertex 4", "vertex 4000000000")), CorruptData);
  EXPECT_THROW(read_ply(with("4 0 1 2 3", "4 0 1 2 7")), CorruptData);
  EXPECT_THROW(read_ply(with("4 0 1 2 3", "4 0 1 2 -1")), CorruptData);
  EXPECT_THROW(read_ply(with("4 0 1 2 3", "250 0 1 2 3")), CorruptData);
  EXPECT_THROW(read_ply(folder.path / "absent.ply"), InvalidInput);
  EXPECT_THROW(write_ply(folder.path / "no" / "such" / "folder.ply", tetrahedron()), std::system_error);
}

TEST(Smoothing, KeepsTheVolumeAndTakesOffRoughness) {
  auto mesh = surface_of(tests::ball({0, 0, 0}, 0.1), 0.16, 0.02);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.positions[v] *= v % 2 == 0 ? 1.03F : 0.97F;
  const auto roughness = [&] {
    double sum = 0.0;
    for (const auto& p : mesh.positions) sum += std::abs(static_cast<double>(p.norm()) - 0.1);
    return sum / static_cast<double>(mesh.positions.size());
  };
  const double before = roughness(), volume = signed_volume(mesh);
  smooth(mesh);
  EXPECT_LT(roughness(), 0.5 * before);
  EXPECT_NEAR(signed_volume(mesh), volume, 1e-3 * volume);
}

TEST(Smoothing, KeepsAThinLimbsLengthAndGirth) {
  const tests::CapsuleBody limb{{{0, 0, -0.1}, {0, 0, 0.1}, 0.03}};
  auto mesh = surface_of(limb, 0.16, 0.01);
  smooth(mesh);
  for (const auto& p : mesh.positions) EXPECT_NEAR(tests::signed_distance(limb, p.cast<double>()), 0.0, 0.003);
}

TEST(Simplify, KeepsASphereASphereNearItself) {
  auto mesh = surface_of(tests::ball({0, 0, 0}, 0.1), 0.16, 0.01);
  const auto before = mesh.triangles.size();
  simplify(mesh, before / 4);
  EXPECT_LE(mesh.triangles.size(), before / 4);
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  EXPECT_NEAR(signed_volume(mesh), 4.0 / 3.0 * std::numbers::pi * 1e-3,
              0.02 * 4.19e-3);  // an inscribed polyhedron of this many triangles lacks about 1 %
}

TEST(Simplify, CollapsesSlivers) {
  auto mesh = surface_of(tests::ball({0.0013, 0.0007, -0.0021}, 0.1), 0.16, 0.01);
  const auto short_edges = [&] {
    int count = 0;
    for (const auto& t : mesh.triangles)
      for (std::size_t i = 0; i < 3; ++i)
        count += (mesh.positions[t[i]] - mesh.positions[t[(i + 1) % 3]]).norm() < 0.002F ? 1 : 0;
    return count;
  };
  const int before = short_edges();
  ASSERT_GT(before, 100);
  EXPECT_GT(collapse_slivers(mesh, 0.002), 0U);
  EXPECT_LT(short_edges(), before / 10);  // a few stay: collapsing them would turn a neighbour over or pinch
  EXPECT_TRUE(topology_of(mesh).is_sphere());
}

TEST(Simplify, RefusesWhatIsNoSurface) {
  auto mesh = tetrahedron();
  mesh.triangles.push_back({0, 2, 1});
  EXPECT_THROW(collapse_slivers(mesh, 0.1), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
