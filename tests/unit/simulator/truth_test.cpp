#include "simulator/studio/truth.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/prepared_act.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/exposure_log.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;

// Distance along a ray to the nearest triangle (Moeller and Trumbore 1997); infinity if there is none.
double ray_hit(const recon::TriangleMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d { return mesh.positions[t[i]].cast<double>(); };
    const Eigen::Vector3d e1 = corner(1) - corner(0), e2 = corner(2) - corner(0), p = along.cross(e2);
    const double det = e1.dot(p);
    if (std::abs(det) < 1e-15) continue;
    const Eigen::Vector3d s = from - corner(0), q = s.cross(e1);
    const double u = s.dot(p) / det, v = along.dot(q) / det, d = e2.dot(q) / det;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && d > 0.0) nearest = std::min(nearest, d);
  }
  return nearest;
}

TEST(Truth, DepthIsWhereTheRayThroughThePixelsCentreMeetsTheSurface) {
  auto star = tests::starfish(4);
  for (auto& p : star.positions) p = 0.6F * p + Eigen::Vector3f(0.0F, 0.0F, 0.9F);
  const std::vector<recon::TriangleMesh> surfaces{star};
  const auto camera = camera_layout({.cameras = 2, .width = 160, .height = 128, .skew_px = 2.0, .k1 = -0.1}).front();
  const cv::Mat depth = true_depth(camera, surfaces);
  ASSERT_EQ(depth.type(), CV_32FC1);
  int body = 0, wrong = 0, compared = 0;
  double sum = 0.0;
  for (int y = 1; y < depth.rows; y += 3)
    for (int x = 1; x < depth.cols; x += 3) {
      const Eigen::Vector3d along = *capture::ray_through(camera, {x, y});
      const double hit = ray_hit(surfaces.front(), camera.centre(), along);
      const double wanted = std::isinf(hit) ? 0.0 : hit * camera.axis().dot(along);
      const double got = depth.at<float>(y, x);
      body += wanted > 0.0;
      ++compared;
      if (std::abs(got - wanted) > 0.002)
        ++wrong;  // an outline that passes between two straight edges of the distorted picture
      else
        sum += std::abs(got - wanted);
    }
  EXPECT_GT(body, 40);
  EXPECT_LE(wrong, body / 50);
  EXPECT_LT(sum / compared, 1e-5);
}

class TruthFolder : public testing::Test {
 protected:
  TruthFolder() { fs::remove_all(folder_); }
  ~TruthFolder() override { fs::remove_all(folder_); }
  nlohmann::json json(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return nlohmann::json::parse(in);
  }
  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("truth_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(TruthFolder, AnActIsPreparedOnceAndItsTruthLiesBeside) {
  ActOptions options{.performance = {.act = "a-pose", .coarseness = 1.4, .texels_per_edge = 2},
                     .cameras = camera_layout({.cameras = 2, .width = 80, .height = 64}),
                     .cache = FrameCache::Options{.folder = folder_ / "cache"},
                     .truth = folder_ / "truth"};
  int rendered = 0;
  options.progress = [&](int done, int) { rendered += done > 0; };
  const auto player = prepare_act(options);
  ASSERT_TRUE(player);
  EXPECT_EQ(rendered, player->frames());
  const capture::Timestamp any(std::chrono::hours(500'000));
  const auto shown = player->picture_at(1, any);
  EXPECT_EQ(shown.size(), 80U * 64U);

  const auto again = prepare_act(options);  // pictures and truth are there
  options.truth.reset();
  const auto without_truth = prepare_act(options);
  EXPECT_EQ(rendered, player->frames());
  for (auto* other : {again.get(), without_truth.get()}) {
    const auto same = other->picture_at(1, any);
    EXPECT_TRUE(std::equal(shown.begin(), shown.end(), same.begin(), same.end()));
  }

  const auto truth = folder_ / "truth";
  const auto performance = make_performance(options.performance);
  EXPECT_EQ(json("truth/truth.json").at("act_frames"), performance->frames());
  const auto joints = json("truth/joints.json");
  ASSERT_EQ(joints.at("joints").size(), performance->joints().size());
  const auto pelvis = performance->joints_at(0.0).front().position;
  EXPECT_NEAR(joints.at("frames").at(0).at("positions").at(0).at(2), pelvis.z(), 1e-12);
  EXPECT_EQ(capture::read_calibration(truth / "calibration.yaml").size(), 2U);
  const auto mesh = recon::read_ply(truth / "meshes/frame000000.ply");
  const auto surface = performance->surfaces_at(0.0).front();
  EXPECT_EQ(mesh.triangles, surface.triangles);  // vertex numbers are stable
  EXPECT_EQ(mesh.positions, surface.positions);
  const auto matte = capture::read_grey(truth / "mattes/cam01/frame000000.png");
  const cv::Mat depth = cv::imread((truth / "depth/cam01/frame000000.exr").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_32FC1);
  const cv::Mat disagree = (matte > 250) & (depth <= 0.0F);
  EXPECT_GT(cv::countNonZero(matte > 250), 100);
  EXPECT_LE(cv::countNonZero(disagree), 2);
}

TEST_F(TruthFolder, ADamagedCacheIsRenderedAgainAndAnInterruptedOneGoesOn) {
  ActOptions options{.performance = {.act = "walk", .coarseness = 1.4, .texels_per_edge = 2},
                     .cameras = camera_layout({.cameras = 2, .width = 32, .height = 24}),
                     .cache = FrameCache::Options{.folder = folder_}};
  std::stop_source stop;
  options.stop = stop.get_token();
  options.progress = [&](int done, int) {
    if (done == 2) stop.request_stop();
  };
  EXPECT_FALSE(prepare_act(options));
  options.stop = {};
  int left = -1;
  options.progress = [&](int done, int all) {
    if (done == 0) left = all;
  };
  const auto player = prepare_act(options);
  ASSERT_TRUE(player);
  EXPECT_EQ(left, player->frames() - 2);
  for (const auto& item : fs::recursive_directory_iterator(folder_))
    if (item.path().filename() == "frame000001.pictures") {
      std::fstream flipped(item.path(), std::ios::in | std::ios::out | std::ios::binary);
      flipped.seekp(-3, std::ios::end);
      flipped.put('!');
    }
  left = -1;
  EXPECT_TRUE(prepare_act(options));
  EXPECT_EQ(left, 1);
}

TEST_F(TruthFolder, ExposuresCanBeReadWhileTheyAreWritten) {
  fs::create_directories(folder_);
  const auto file = folder_ / "exposures.jsonl";
  ExposureLog log(file, {"cam00", "cam01"});
  const capture::Timestamp start(std::chrono::nanoseconds(1'700'000'000'123'456'789));
  log.add({.camera = 1, .block = 7, .start = start, .duration = std::chrono::microseconds(1250)}, 13);
  std::string line;
  for (int i = 0; i < 1000 && line.empty(); ++i) {  // the log lives on: this is what a reader after kill -9 finds
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::ifstream in(file);
    std::getline(in, line);
  }
  const auto exposure = nlohmann::json::parse(line);
  EXPECT_EQ(exposure.at("camera"), "cam01");
  EXPECT_EQ(exposure.at("block"), 7);
  EXPECT_EQ(exposure.at("exposure_start_ns"), 1'700'000'000'123'456'789);
  EXPECT_EQ(exposure.at("exposure_ns"), 1'250'000);
  EXPECT_EQ(exposure.at("act_frame"), 13);
  EXPECT_EQ(log.lost(), 0U);
}

}  // namespace
}  // namespace rotunda::simulator
