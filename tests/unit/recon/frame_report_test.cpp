#include "recon/frame_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

TEST(FrameReport, TellsWhatTheSurfaceIsAndWhatItCost) {
  const auto cameras = simulator::camera_layout({.width = 160, .height = 128});
  const auto body = tests::ball({0.0, 0.0, 1.0}, 0.4);
  SurfaceOptions options;
  options.bounds.emplace(Eigen::Vector3d(-0.6, -0.6, 0.4), Eigen::Vector3d(0.6, 0.6, 1.6));
  options.cell_size = 0.03;
  const auto result = reconstruct_surface(cameras, tests::mattes_of(body, cameras), options);
  const auto report = nlohmann::json::parse(frame_report(7, result.failure, result.report, 0.25));
  EXPECT_EQ(report["frame"], 7);
  EXPECT_FALSE(report.contains("failure"));
  EXPECT_EQ(report["euler_characteristic"], 2);
  EXPECT_EQ(report["triangles"], result.mesh.triangles.size());
  EXPECT_NEAR(report["volume"].get<double>(), 0.268, 0.03);  // of the ball; drawn in nearly to it
  EXPECT_NEAR(report["area"].get<double>(), 2.01, 0.2);
  EXPECT_EQ(report["unseen_share"], 0.25);
  double wall = 0.0;
  for (const auto& stage : report["stages"]) wall += stage["wall_ms"].get<double>();
  EXPECT_GT(wall, 0.0);
  EXPECT_EQ(nlohmann::json::parse(frame_report(8, "cam01: no", {}, std::nullopt))["failure"], "cam01: no");
}

TEST(FrameReport, CountsWhatNoCameraSaw) {
  GeometryImage image;
  image.coverage = {255, 0, 0, 255, 255, 255, 255, 255};
  EXPECT_EQ(unseen_share(image), 0.25);
}

}  // namespace
}  // namespace rotunda::recon
