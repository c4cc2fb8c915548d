// A scan moved by somebody's motion: the simulator's person and act, through files, as people would do it.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "recon/gltf/gltf_character.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/people/person.h"
#include "tests/integration/house_test.h"
#include "tests/support/act_bvh.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class Animate : public HouseTest {
 protected:
  void SetUp() override {
    HouseTest::SetUp();
    const auto person = simulator::make_person("anna");
    auto motion = simulator::motion_of("kick", person.skeleton);
    motion.frames = std::min(motion.frames, 12);
    recon::write_bvh(file("kick.bvh"), act_bvh(person.skeleton, motion));
    const auto scan = run("rotunda-sim", {"--scan", "alex", "--triangles", "6000", "-o", file("scan.ply")});
    ASSERT_EQ(scan.exit_code, 0) << scan.err;
  }
  std::string file(const char* name) const { return (folder() / name).string(); }

  // The scan as OBJ with one picture: red above 1 m, blue below.
  void write_textured_obj() const {
    cv::Mat picture(64, 64, CV_8UC3, cv::Scalar(0, 0, 255));
    picture.rowRange(32, 64).setTo(cv::Scalar(255, 0, 0));
    cv::imwrite(file("skin.png"), picture);
    std::ofstream(file("scan.mtl")) << "newmtl skin\nmap_Kd skin.png\n";
    std::ofstream obj(file("scan.obj"));
    obj << "mtllib scan.mtl\nusemtl skin\n";
    const auto mesh = recon::read_ply(file("scan.ply"));
    for (const auto& p : mesh.positions)
      obj << fmt::format("v {} {} {}\nvt 0.5 {}\n", p.x(), p.y(), p.z(), p.z() / 2.0F);
    for (const auto& t : mesh.triangles)
      obj << fmt::format("f {0}/{0} {1}/{1} {2}/{2}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
};

TEST_F(Animate, MovesAnyScanWithoutAClickAndKeepsItsMarkersForPeople) {
  const auto moved = rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("scan.ply"), "--write-markers",
                              file("markers.yaml"), "-o", file("kick.glb"), "--json"});
  ASSERT_EQ(moved.exit_code, 0) << moved.err;
  EXPECT_THAT(moved.out, AllOf(HasSubstr("\"frames\": 12"), HasSubstr("drift_mm")));
  EXPECT_GT(fs::file_size(file("kick.glb")), 100'000U);
  const auto again = rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("scan.ply"), "--markers",
                              file("markers.yaml"), "-o", file("kick.obj")});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(fs::exists(file("kick.pc2")));
}

TEST_F(Animate, ScansWithPicturesKeepTheirColours) {
  write_textured_obj();
  const auto animate = [&](const char* scan, const char* output) {
    return rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file(scan), "-o", file(output)});
  };
  const auto moved = animate("scan.obj", "kick.glb");
  ASSERT_EQ(moved.exit_code, 0) << moved.err;
  EXPECT_THAT(moved.out, testing::Not(HasSubstr("no colours")));
  const auto red_above = [&] {
    const auto character = recon::read_gltf_character(file("kick.glb"));
    const auto& part = character.parts.at(0);
    std::size_t right = 0;
    for (std::size_t v = 0; v < part.positions.size(); ++v) {
      const auto& colour = part.colours.at(v);
      if ((part.positions[v].y() > 1.0F) == (colour[0] > colour[2])) ++right;  // there y is up
    }
    return static_cast<double>(right) / static_cast<double>(part.positions.size());
  };
  EXPECT_GT(red_above(), 0.97);                         // but where red meets blue
  const auto again = animate("kick.glb", "again.glb");  // what came out goes in
  ASSERT_EQ(again.exit_code, 0) << again.err;
  fs::remove(file("kick.glb"));
  fs::rename(file("again.glb"), file("kick.glb"));
  EXPECT_GT(red_above(), 0.97);
  fs::remove(file("skin.png"));
  const auto grey = animate("scan.obj", "grey.glb");
  ASSERT_EQ(grey.exit_code, 0) << grey.err;
  EXPECT_THAT(grey.out, HasSubstr("its picture skin.png is missing"));
  std::ofstream(file("cut.glb")) << "glTF cut";
  const auto cut = animate("cut.glb", "x.glb");
  EXPECT_EQ(cut.exit_code, 3);
  EXPECT_THAT(cut.err, AllOf(HasSubstr("cut.glb"), HasSubstr("ends within its header")));
}

TEST_F(Animate, ShowsItsMarkersAsTheEditorDoesAndGoesOnWhereOneWasLeft) {
  const auto edit = [&](const std::string& scan) {
    return rotunda({"animate", "--motion", file("kick.bvh"), "--scan", scan, "--edit", file("markers.yaml"),
                    "--picture", file("editor.png")});
  };
  const auto shown = edit(file("scan.ply"));
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_GT(fs::file_size(file("editor.png")), 50'000U);
  EXPECT_FALSE(fs::exists(file("markers.yaml")));  // nothing was saved
  std::ofstream(file("markers.yaml.unsaved")) << "markers:\n  - {number: 1, template: 4, scan: 5}\n";
  const auto again = edit(file("scan.ply"));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("goes on where it was left without saving"));
  EXPECT_TRUE(fs::exists(file("markers.yaml.unsaved")));
  std::ofstream(file("markers.yaml.unsaved")) << "markers:\n  - {number: 1, template: 4, scan: 900000}\n";
  const auto other = edit(file("scan.ply"));  // another scan's
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_THAT(other.err, AllOf(HasSubstr("markers.yaml.unsaved"), HasSubstr("the scan has no triangle 900000")));
  const auto nowhere = rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("scan.ply"), "--edit",
                                file("no/markers.yaml"), "--picture", file("editor.png")});
  EXPECT_EQ(nowhere.exit_code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("there is no folder"));
  const auto nothing = rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("scan.ply")});
  EXPECT_EQ(nothing.exit_code, 3);
  EXPECT_THAT(nothing.err, HasSubstr("--edit"));
}

TEST_F(Animate, RefusesWhatCannotBeMovedAndSaysWhatToDo) {
  std::ofstream(file("points.ply")) << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                       "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
                                       "end_header\n0 0 0\n";
  const auto points =
      rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("points.ply"), "-o", file("x.glb")});
  EXPECT_EQ(points.exit_code, 3);
  EXPECT_THAT(points.err, HasSubstr("no triangles"));
  std::ofstream(file("bad.yaml")) << "markers:\n  - {number: 1, template: 4, scan: 900000}\n";
  const auto markers = rotunda({"animate", "--motion", file("kick.bvh"), "--scan", file("scan.ply"), "--markers",
                                file("bad.yaml"), "-o", file("x.glb")});
  EXPECT_EQ(markers.exit_code, 3);
  EXPECT_THAT(markers.err, HasSubstr("the scan has no triangle 900000"));
  std::ofstream(file("cut.bvh")) << "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\n";
  const auto cut = rotunda({"animate", "--motion", file("cut.bvh"), "--scan", file("scan.ply"), "-o", file("x.glb")});
  EXPECT_EQ(cut.exit_code, 3);
  EXPECT_FALSE(fs::exists(file("x.glb")));
}

}  // namespace
}  // namespace rotunda::tests
