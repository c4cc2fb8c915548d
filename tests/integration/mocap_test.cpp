// Pictures of somebody walking through import and mocap; and what mocap refuses.
#include <fmt/format.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "recon/body/body_track.h"
#include "recon/body/bvh.h"
#include "recon/mesh/mesh_file.h"
#include "tests/integration/house_test.h"
#include "tests/support/template_scene.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kFrames = 6;

// Mattes of the template walking, before pictures that show nothing else; in the empty frames nobody is there.
class Mocap : public HouseTest {
 protected:
  Mocap() : cameras_(ring_around_person(6, 160, 160)), body_(recon::template_of_height(1.72)) {
    capture::write_calibration(folder() / "calibration.yaml", cameras_);
  }

  Outcome import(const std::set<int>& empty) {
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto mesh = recon::pose_template(body_, pose(frame));
      for (const auto& camera : cameras_) {
        const auto matte = empty.count(frame) > 0 ? cv::Mat(cv::Mat::zeros(camera.height, camera.width, CV_8UC1))
                                                  : silhouette_of(mesh, camera).alpha;
        cv::Mat picture(camera.height, camera.width, CV_8UC3, cv::Scalar(30, 60, 200));
        picture.setTo(cv::Scalar(200, 170, 140), matte);
        write("images", camera.name, frame, picture);
        write("mattes", camera.name, frame, matte);
      }
    }
    return rotunda({"take", "import", "walk", "--images", (folder() / "images").string(), "--mattes",
                    (folder() / "mattes").string(), "--calibration", (folder() / "calibration.yaml").string()});
  }
  recon::Pose pose(int frame) const { return walking_pose(body_, 0.1 + 0.04 * frame); }
  void write(const std::string& kind, const std::string& camera, int frame, const cv::Mat& picture) {
    fs::create_directories(folder() / kind / camera);
    capture::write_png(folder() / kind / camera / fmt::format("{:03}.png", frame), picture);
  }
  Outcome mocap(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"mocap", "walk", "-o", (folder() / "walk.bvh").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return rotunda(arguments);
  }

  std::vector<capture::CameraModel> cameras_;
  recon::BodyTemplate body_;
};

TEST_F(Mocap, PutsTheTakesPicturesOnTheMovedScan) {
  ASSERT_EQ(import({}).exit_code, 0);
  const auto scan = (folder() / "scan.ply").string(), video = (folder() / "video").string();
  ASSERT_EQ(run("rotunda-sim", {"--scan", "alex", "--triangles", "6000", "-o", scan}).exit_code, 0);
  const auto outcome = rotunda({"animate", "--motion", "walk", "--frames", "1:3", "--scan", scan, "--view-dependent",
                                "--beside-template", "-o", video});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(folder() / "video/frame000002.png"));
  const auto picture = cv::imread((folder() / "video/frame000001.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.size(), cv::Size(1440, 720));
  for (const int left : {0, 720}) {  // scan, template
    cv::Mat seen, performer;
    cv::extractChannel(picture.colRange(left, left + 720), seen, 3);
    cv::inRange(picture.colRange(left, left + 720), cv::Scalar(125, 155, 185, 255), cv::Scalar(155, 185, 215, 255),
                performer);
    EXPECT_GT(cv::countNonZero(seen), 10'000);
    EXPECT_GT(cv::countNonZero(performer), 0.9 * cv::countNonZero(seen));  // the pictures' colour, not the scan's
  }
}

TEST_F(Mocap, SaysWhatA3dVideoNeeds) {
  const auto scan = (folder() / "scan.ply").string(), motion = (folder() / "walk.bvh").string();
  for (const auto& file : {scan, motion}) std::ofstream(file) << "not looked at\n";
  const auto bvh = rotunda({"animate", "--motion", motion, "--scan", scan, "--view-dependent", "-o", "x.mp4"});
  EXPECT_EQ(bvh.exit_code, 3);
  EXPECT_THAT(bvh.err, HasSubstr("give the take as --motion"));
  const auto glb = rotunda({"animate", "--motion", "walk", "--scan", scan, "--view-dependent", "-o", "x.glb"});
  EXPECT_EQ(glb.exit_code, 3);
  EXPECT_THAT(glb.err, HasSubstr("a 3D video is a .mp4"));
}

TEST_F(Mocap, FollowsAWalkAndTellsTheFrameWithoutAnybody) {
  ASSERT_EQ(import({4}).exit_code, 0);
  const auto joints_file = folder() / "joints.json", film = folder() / "walk.mp4", meshes = folder() / "template";
  const auto outcome =
      mocap({"--joints", joints_file.string(), "--template", meshes.string(), "--overlay", film.string(), "--json"});
  ASSERT_EQ(outcome.exit_code, 1) << outcome.err;  // done, but with loss
  const auto report = json::parse(outcome.out);
  EXPECT_EQ(report["frames"], kFrames);
  EXPECT_EQ(report["lost"], 1);
  EXPECT_EQ(report["lost_stretches"][0]["frames"], "4:5");
  EXPECT_NEAR(report["height_m"].get<double>(), 1.72, 0.04);
  EXPECT_THAT(outcome.err, HasSubstr("lost in 4:5: 0 of 6 silhouettes show anybody"));

  EXPECT_EQ(recon::read_bvh(folder() / "walk.bvh").frames, static_cast<std::size_t>(kFrames));
  EXPECT_EQ(recon::read_ply(meshes / "frame000005.ply").positions.size(),
            recon::kBodySegments * recon::vertices_of_segment());
  EXPECT_GT(fs::file_size(film), 1000U);
  std::ifstream stream(joints_file);
  const auto joints = json::parse(stream);
  EXPECT_EQ(joints["frames"][4]["state"], "lost");
  const auto truth = recon::joint_positions(body_.skeleton, pose(5));
  double error = 0.0;
  for (std::size_t j = 0; j < recon::kBodyJoints; ++j) {
    const auto& p = joints["frames"][5]["positions"][j];
    error += (Eigen::Vector3d(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()) - truth[j]).norm();
  }
  EXPECT_LT(error / recon::kBodyJoints, 0.04);  // a pixel is 17 mm
}

TEST_F(Mocap, KeepsTheMeasuresThatAnotherTakeTold) {
  ASSERT_EQ(import({}).exit_code, 0);
  const auto known = folder() / "known.json", again = folder() / "again.json";
  const recon::CapturedMotion other{.body = recon::template_of_height(1.76), .frames = {{.fit = {.pose = pose(0)}}}};
  recon::write_joints_json(known, other);
  const auto outcome = mocap({"--measures", known.string(), "--joints", again.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(recon::read_joints_json(again).body.measures, other.body.measures);
}

TEST_F(Mocap, PaperModeMatchesFramesOnTheSphere) {
  ASSERT_EQ(import({}).exit_code, 0);
  const auto outcome = rotunda({"recon", "walk", "--paper", "--align", "--frames", "0:2", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto alignment = json::parse(outcome.out)["alignment"];
  EXPECT_EQ(alignment["how"], "matching") << alignment.dump(2);
  ASSERT_EQ(alignment["frames"].size(), 2U);
  EXPECT_EQ(alignment["frames"][1]["folds"], 0);
  EXPECT_LT(alignment["frames"][1]["residual_mean_mm"].get<double>(), 5.0) << "it is the frame's own surface still";
}

TEST_F(Mocap, RefusesSomebodyElsesMeasures) {
  ASSERT_EQ(import({}).exit_code, 0);
  const auto childs = folder() / "child.json";
  recon::write_joints_json(childs,
                           {.body = recon::template_of_height(1.1), .frames = {{.fit = {.pose = recon::rest_pose()}}}});
  const auto outcome = mocap({"--measures", childs.string()});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("walk"), HasSubstr("1.10 m tall"), HasSubstr("somebody else")));
  EXPECT_FALSE(fs::exists(folder() / "walk.bvh"));
}

TEST_F(Mocap, RefusesATakeWithoutAnybodyAndSaysWhatToLookAt) {
  ASSERT_EQ(import({0, 1, 2, 3, 4, 5}).exit_code, 0);
  const auto outcome = mocap();
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("walk"), HasSubstr("mattes"), HasSubstr("rotunda recon")));
  EXPECT_FALSE(fs::exists(folder() / "walk.bvh"));
}

}  // namespace
}  // namespace rotunda::tests
