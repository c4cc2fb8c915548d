// rotunda map and rotunda export as people call them: a mesh to the sphere and back, every kind of bad mesh refused by
// name, a geometry video written for other programs.
#include <fmt/format.h>

#include <fstream>
#include <limits>

#include "recon/mesh/mesh_file.h"
#include "recon/video/geometry_video.h"
#include "tests/integration/house_test.h"
#include "tests/support/closed_shapes.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using recon::TriangleMesh;
using testing::HasSubstr;

// As text, faulty or not; write_ply would refuse.
void write_as_text(const fs::path& file, const TriangleMesh& mesh) {
  std::ofstream ply(file);
  ply << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& p : mesh.positions) ply << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const auto& t : mesh.triangles) ply << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
}

TriangleMesh two_spheres() {
  auto mesh = icosphere(2);
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  const auto other = mesh;
  for (const auto& p : other.positions) mesh.positions.push_back(p + Eigen::Vector3f(5.0F, 0.0F, 0.0F));
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  return mesh;
}

// Both spheres share vertex 0.
TriangleMesh spheres_that_touch() {
  auto mesh = two_spheres();
  const auto second = static_cast<std::uint32_t>(mesh.positions.size() / 2);
  for (auto& t : mesh.triangles)
    for (auto& v : t)
      if (v == second) v = 0;
  return mesh;
}

TriangleMesh ring() {
  constexpr std::uint32_t kAround = 12, kAcross = 8;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kAround; ++i)
    for (std::uint32_t j = 0; j < kAcross; ++j) {
      const float a = 2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / kAround;
      const float b = 2.0F * std::numbers::pi_v<float> * static_cast<float>(j) / kAcross;
      const float out = 1.0F + 0.3F * std::cos(b);
      mesh.positions.emplace_back(out * std::cos(a), out * std::sin(a), 0.3F * std::sin(b));
      const auto p = i * kAcross + j, q = (i + 1) % kAround * kAcross + j;
      const auto r = i * kAcross + (j + 1) % kAcross, s = (i + 1) % kAround * kAcross + (j + 1) % kAcross;
      mesh.triangles.push_back({p, q, r});
      mesh.triangles.push_back({r, q, s});
    }
  return mesh;
}

class MeshCommand : public HouseTest {};

TEST_F(MeshCommand, MapsAMeshToTheSphereAndBack) {
  const auto mesh = icosphere(3);
  write_as_text(folder() / "ball.ply", mesh);
  const auto outcome =
      rotunda({"map", (folder() / "ball.ply").string(), "--level", "5", "--sphere", (folder() / "sphere.ply").string(),
               "--remesh", (folder() / "remesh.ply").string(), "-o", (folder() / "image.png").string(), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("flips"), 0);
  const auto sphere = recon::read_ply(folder() / "sphere.ply");
  EXPECT_EQ(sphere.triangles, mesh.triangles);
  for (const auto& p : sphere.positions) EXPECT_NEAR(p.norm(), 1.0F, 1e-6F);
  const auto remesh = recon::read_ply(folder() / "remesh.ply");
  EXPECT_TRUE(recon::topology_of(remesh).is_sphere());
  for (const auto& p : remesh.positions) EXPECT_NEAR(p.norm(), 1.0F, 0.02F);
  EXPECT_TRUE(fs::exists(folder() / "image.png"));
}

// As marching cubes makes them: two corners in one place, two triangles of 20,480 without area.
TEST_F(MeshCommand, TellsOfTheOddTriangleWithoutAreaAndMapsIt) {
  auto mesh = icosphere(5);
  mesh.positions[mesh.triangles[0][0]] = mesh.positions[mesh.triangles[0][1]];
  write_as_text(folder() / "ball.ply", mesh);
  const auto outcome = rotunda({"map", (folder() / "ball.ply").string(), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("2 triangle(s) of no area"));
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("flips"), 0);
}

TEST_F(MeshCommand, RefusesEachBadMeshByName) {
  auto open = icosphere(2), not_a_number = open, without_area = open;
  open.triangles.pop_back();
  not_a_number.positions[7].x() = std::numeric_limits<float>::quiet_NaN();
  without_area.positions[without_area.triangles[0][0]] = without_area.positions[without_area.triangles[0][1]];
  const std::vector<std::tuple<std::string, TriangleMesh, std::string>> bad{
      {"open", open, "not closed"},
      {"touching", spheres_that_touch(), "not manifold"},
      {"two", two_spheres(), "2 separate surfaces"},
      {"ring", ring(), "not of genus 0: it has 1 handle"},
      {"flat", without_area, "has no area"},
      {"nan", not_a_number, "no number"},
      {"empty", {}, "no triangles"},
  };
  for (const auto& [name, mesh, reason] : bad) {
    const auto file = folder() / (name + ".ply"), sphere = folder() / (name + "-sphere.ply");
    write_as_text(file, mesh);
    const auto outcome = rotunda({"map", file.string(), "--sphere", sphere.string()});
    EXPECT_EQ(outcome.exit_code, 3) << name;
    EXPECT_THAT(outcome.err, HasSubstr(file.string()));
    EXPECT_THAT(outcome.err, HasSubstr(reason));
    EXPECT_FALSE(fs::exists(sphere)) << name;
  }
  std::ofstream(folder() / "nan.obj") << "v 0 0 0\nv 1 0 nan\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  const auto obj = rotunda({"map", (folder() / "nan.obj").string()});
  EXPECT_EQ(obj.exit_code, 3);
  EXPECT_THAT(obj.err, HasSubstr("v 1 0 nan"));
  const auto missing = rotunda({"map", (folder() / "missing.ply").string()});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.err, HasSubstr("no such file"));
}

TEST_F(MeshCommand, ExportsAGeometryVideo) {
  const auto clip = (folder() / "clip.mkv").string();
  const std::vector<recon::GeometryImage> images{test::round_geometry_image({.level = 5, .colour_level = 5}),
                                                 test::round_geometry_image({.level = 5, .colour_level = 5})};
  recon::write_geometry_video(clip, images);
  const auto outcome = rotunda({"export", clip, "--to", "ply", "-o", (folder() / "out").string(), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("frames"), 2);
  const auto smooth = (folder() / "smooth.avi").string();
  const auto faster = rotunda({"export", clip, "--to", "master", "--fps", "50", "--level", "4", "-o", smooth});
  ASSERT_EQ(faster.exit_code, 0) << faster.err;
  const auto shown = rotunda({"show", smooth, "--json"});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  const auto contents = nlohmann::json::parse(shown.out);
  EXPECT_EQ(contents.at("profile"), "master");
  EXPECT_EQ(contents.at("frames"), 3);
  EXPECT_EQ(contents.at("fps"), 50.0);
  EXPECT_EQ(contents.at("level"), 4);
  const auto onto_itself = rotunda({"export", clip, "--to", "master", "-o", clip});
  EXPECT_EQ(onto_itself.exit_code, 3);
  EXPECT_THAT(onto_itself.err, HasSubstr("another name"));
  fs::resize_file(clip, fs::file_size(clip) / 3);
  const auto cut = rotunda({"export", clip, "--to", "glb", "-o", (folder() / "cut.glb").string()});
  EXPECT_NE(cut.exit_code, 0);
  EXPECT_THAT(cut.err, HasSubstr(clip));
}

}  // namespace
}  // namespace rotunda::tests
