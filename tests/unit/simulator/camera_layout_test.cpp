#include "simulator/studio/camera_layout.h"

#include <gtest/gtest.h>

#include "config/errors.h"
#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

bool sees(const capture::CameraModel& camera, const Vector3d& point) {
  const auto seen = capture::project(camera, point);
  return seen && seen->x() >= 0 && seen->y() >= 0 && seen->x() <= camera.width - 1 && seen->y() <= camera.height - 1;
}

double rows_of_a_person(const capture::CameraModel& camera) {
  return (*capture::project(camera, {0.0, 0.0, 0.0}) - *capture::project(camera, {0.0, 0.0, 1.75})).norm();
}

TEST(CameraLayout, TravellersStayInEveryPictureAndAreTall) {
  for (const int cameras : {2, 4, 10, 16, 64})
    for (const double k1 : {0.0, -0.15, 0.08}) {
      const auto rig = camera_layout(travelling_layout({.cameras = cameras, .k1 = k1}));
      for (std::size_t i = 0; i < rig.size(); ++i) {
        for (int corner = 0; corner < 8; ++corner)
          EXPECT_TRUE(sees(rig[i], kStageVolume.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))))
              << cameras << " cameras, " << rig[i].name;
        const bool is_high = static_cast<int>(i) >= cameras - cameras / 5;
        if (!is_high && k1 == 0.0) {
          EXPECT_GT(rows_of_a_person(rig[i]), 325.0) << rig[i].name;
        }
        EXPECT_LE(rig[i].centre().z(), 4.5 + 1e-9);
      }
    }
}

TEST(CameraLayout, NoLampHangsBetweenACameraAndTheStage) {
  for (const int cameras : {5, 10, 16})
    for (const auto& layout : {LayoutOptions{.cameras = cameras}, travelling_layout({.cameras = cameras})})
      for (const auto& camera : camera_layout(layout))
        for (const auto& lamp : lamps()) {
          const Vector3d way = Vector3d(0.0, 0.0, 1.0) - camera.centre();
          const auto hit = hit_lamp(lamp, camera.centre(), way.normalized());
          EXPECT_FALSE(hit && hit->distance < way.norm()) << cameras << " cameras, " << camera.name;
        }
}

TEST(CameraLayout, OnTheSpotAPersonIsTallerStill) {
  for (const auto& camera : camera_layout({.cameras = 4})) EXPECT_GT(rows_of_a_person(camera), 350.0) << camera.name;
}

TEST(CameraLayout, LensesForTheSpotDoNotHoldTheStageAndThoseForTravellersDo) {
  for (const auto& camera : camera_layout({.cameras = 4})) EXPECT_FALSE(holds(camera, kStageVolume)) << camera.name;
  for (const auto& camera : camera_layout(travelling_layout())) EXPECT_TRUE(holds(camera, kStageVolume)) << camera.name;
}

TEST(CameraLayout, ACameraAmidTheStageIsRefused) {
  auto layout = travelling_layout();
  layout.radius = 1.2;
  EXPECT_THROW(camera_layout(layout), InvalidInput);
}

}  // namespace
}  // namespace rotunda::simulator
