#include "capture/calibration/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "capture/calibration/calibration_quality.h"
#include "config/errors.h"
#include "tests/support/board_scene.h"
#include "tests/support/calibration_case.h"

namespace rotunda::capture {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::kBoard;
using tests::named;
using tests::names_of;
using tests::options;
using tests::worst_baseline;

// The last board of the walk lies at the world's origin, so no alignment is needed.
TEST(Calibrate, ExactCornersGiveTheRigExactly) {
  const auto rig = tests::board_rig(4);
  const auto walk = tests::board_walk(16);
  const auto result =
      calibrate_sightings(rig, names_of(walk.size()), tests::sightings_of(rig, kBoard, walk), options());
  ASSERT_EQ(result.cameras.size(), rig.size());
  for (std::size_t i = 0; i < rig.size(); ++i) {
    EXPECT_LT((result.cameras[i].centre() - rig[i].centre()).norm(), 1e-6) << rig[i].name;
    EXPECT_LT((result.cameras[i].R - rig[i].R).norm(), 1e-6) << rig[i].name;
    EXPECT_LT((result.cameras[i].K - rig[i].K).norm(), 1e-3) << rig[i].name;  // of 700 px
    EXPECT_LT((result.cameras[i].distortion - rig[i].distortion).norm(), 1e-4) << rig[i].name;
  }
  EXPECT_LT(result.rms_px, 1e-6);
  EXPECT_EQ(result.outliers, 0);
  EXPECT_THAT(result.world, HasSubstr("m15"));
}

TEST(Calibrate, ErrorsAreWhatTheCovarianceSaysAndWrongCornersAreLeftOut) {
  const auto rig = tests::board_rig(4);
  const auto walk = tests::board_walk(24);
  auto sightings = tests::sightings_of(rig, kBoard, walk, 0.1);
  for (std::size_t i = 0; i < sightings.size(); i += 5) sightings[i].corners.front().pixel.x() += 6.0;
  const auto result = calibrate_sightings(rig, names_of(walk.size()), sightings, options());
  EXPECT_NEAR(result.corner_noise_px, 0.1, 0.02);
  EXPECT_EQ(result.outliers, static_cast<int>((sightings.size() + 4) / 5));
  EXPECT_NEAR(result.rms_px, 0.1 * std::sqrt(2.0), 0.02);
  EXPECT_GT(result.held_out_rms_px, 0.9 * result.rms_px);
  Eigen::Matrix3Xd found(3, 4), truth(3, 4);
  for (int i = 0; i < 4; ++i) {
    found.col(i) = result.cameras[static_cast<std::size_t>(i)].centre();
    truth.col(i) = rig[static_cast<std::size_t>(i)].centre();
  }
  const Eigen::Matrix4d aligned = Eigen::umeyama(found, truth, false);
  for (int i = 0; i < 4; ++i) {
    const auto& deviation = result.quality[static_cast<std::size_t>(i)].deviation;
    const double off = ((aligned * found.col(i).homogeneous()).hnormalized() - truth.col(i)).norm();
    EXPECT_LT(off, 3.5 * deviation.centre);  // once in a thousand
    EXPECT_GT(deviation.centre, 0.0002);
    EXPECT_LT(deviation.centre, 0.01);
  }
}

TEST(Calibrate, KeepsGivenIntrinsicsAndTheWorldOfACamera) {
  const auto rig = tests::board_rig(3);
  const auto walk = tests::board_walk(12);
  auto known = options();
  known.known = rig;
  known.world_from = "cam01";
  const auto result =
      calibrate_sightings(rig, names_of(walk.size()), tests::sightings_of(rig, kBoard, walk, 0.05), known);
  for (const auto& camera : result.cameras) {
    EXPECT_EQ(camera.K, named(camera.name, rig).K);
    EXPECT_EQ(camera.distortion, named(camera.name, rig).distortion);
  }
  EXPECT_LT((result.cameras[1].R - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  EXPECT_LT(result.cameras[1].t.norm(), 1e-9);
  const double found = (result.cameras[0].centre() - result.cameras[2].centre()).norm();
  EXPECT_NEAR(found, (rig[0].centre() - rig[2].centre()).norm(), 0.005);
}

TEST(Calibrate, KnownLensesNeedOneBoardOnly) {
  const auto rig = tests::board_rig(4);
  const std::vector<Eigen::Isometry3d> on_floor = {Eigen::Isometry3d::Identity()};
  auto known = options();
  known.known = rig;
  const auto result = calibrate_sightings(rig, names_of(1), tests::sightings_of(rig, kBoard, on_floor, 0.05), known);
  ASSERT_EQ(result.cameras.size(), 4U);
  EXPECT_LT(worst_baseline(result.cameras, rig), 0.02);  // a board of 1 m at 4 m, 0.05 px a corner
  EXPECT_EQ(result.verdict, Verdict::usable);
}

// One board on the floor that all cameras see slantwise, each lens a guess at first: a fair calibration, but not to be
// trusted.
TEST(Calibrate, ASingleBoardGivesAWholeRigThatIsRejected) {
  const auto rig = tests::board_rig(4);
  const std::vector<Eigen::Isometry3d> on_floor = {Eigen::Isometry3d::Identity()};
  const auto result =
      calibrate_sightings(rig, names_of(1), tests::sightings_of(rig, kBoard, on_floor, 0.05), options());
  ASSERT_EQ(result.cameras.size(), 4U);
  for (const auto& camera : result.cameras)  // the wrong of a plane's two poses would ask for another lens altogether
    EXPECT_NEAR(camera.K(0, 0) / named(camera.name, rig).K(0, 0), 1.0, 0.1) << camera.name;
  EXPECT_LT(worst_baseline(result.cameras, rig), 0.5);
  EXPECT_EQ(result.verdict, Verdict::rejected);
  EXPECT_THAT(result.problems, ElementsAre(HasSubstr("no camera saw the board more than once")));
  EXPECT_EQ(result.held_out_moments, 0);
  EXPECT_GT(result.held_out_rms_px, 0.03);
  EXPECT_LT(result.held_out_rms_px, 0.15);
}

// Each camera lists its corners from the end that is to its left, as pictures show them.
TEST(Calibrate, ABoardThatLooksTheSameUpsideDownIsTurnedUntilItFits) {
  const Board board{.type = BoardType::chessboard, .columns = 9, .rows = 7, .square = 0.12, .marker = 0.0};
  ASSERT_TRUE(looks_the_same_upside_down(board));
  const auto rig = tests::board_rig(4);
  const auto as_seen = [&](const std::vector<Eigen::Isometry3d>& walk) {
    auto sightings = tests::sightings_of(rig, board, walk, 0.05);
    for (auto& sighting : sightings)
      if (sighting.corners.front().pixel.x() > sighting.corners.back().pixel.x())
        for (auto& corner : sighting.corners) corner.corner = corner_count(board) - 1 - corner.corner;
    return sightings;
  };
  auto symmetric = options();
  symmetric.boards = {board};
  // Lying boards: cameras on either side see them the other way about.
  auto walk = tests::board_walk(12);
  for (std::size_t i = 0; i < 6; ++i) {
    walk[i].linear().setIdentity();
    walk[i].translation() = Eigen::Vector3d(0.5 * static_cast<double>(i) - 1.25, 0.4 * static_cast<double>(i % 3), 0.1);
  }
  const auto result = calibrate_sightings(rig, names_of(walk.size()), as_seen(walk), symmetric);
  ASSERT_EQ(result.cameras.size(), 4U);
  EXPECT_LT(worst_baseline(result.cameras, rig), 0.02);
  EXPECT_THAT(result.problems, IsEmpty());

  symmetric.known = rig;
  const auto one = calibrate_sightings(rig, names_of(1), as_seen({Eigen::Isometry3d::Identity()}), symmetric);
  EXPECT_EQ(one.verdict, Verdict::rejected);
  EXPECT_THAT(one.problems, Contains(HasSubstr("looks the same upside down")));
}

TEST(Calibrate, RefusesWhatIsTooLittle) {
  const auto rig = tests::board_rig(2);
  const auto walk = tests::board_walk(12);
  const auto all = tests::sightings_of(rig, kBoard, walk);
  EXPECT_THROW(calibrate_sightings(std::span(rig).first(1), names_of(12), all, options()), InvalidInput);
  EXPECT_THROW(calibrate_sightings(rig, names_of(12), {}, options()), InvalidInput);
  std::vector<Sighting> one_camera;
  for (const auto& sighting : all)
    if (sighting.camera == 0) one_camera.push_back(sighting);
  EXPECT_THROW(calibrate_sightings(rig, names_of(12), one_camera, options()), InvalidInput);
}

TEST(Calibrate, SaysWhereToShowTheBoard) {
  CalibrationResult result;
  result.cameras.push_back({.name = "cam07", .width = 640, .height = 480});
  CameraQuality quality;
  quality.views = 4;
  quality.corners = 60;
  quality.coverage.corners.assign(48, 0);
  quality.coverage.corners[40] = 60;  // the last row's first cell
  quality.coverage.outermost_radius = 0.6;
  quality.coverage.nearest = 2.5;
  quality.coverage.farthest = 2.6;
  result.quality.push_back(quality);
  judge(result);
  EXPECT_EQ(result.verdict, Verdict::rejected);
  EXPECT_THAT(result.quality[0].advice,
              Contains(AllOf(HasSubstr("cam07 saw the board 4 times, all in the lower left: show it"),
                             HasSubstr("upper right"), HasSubstr("nearer than 2.0 m"))));
}

// Of whom no board agrees with the others', nothing is said of where those boards were.
TEST(Calibrate, SaysSoWhereNoBoardOfACameraIsOfUse) {
  CalibrationResult result;
  result.cameras.push_back({.name = "cam07", .width = 640, .height = 480});
  result.quality.emplace_back().coverage.corners.assign(48, 0);
  judge(result);
  EXPECT_EQ(result.verdict, Verdict::rejected);
  EXPECT_THAT(result.quality[0].advice, ElementsAre(HasSubstr("cam07: no board it saw agrees")));
}

// Sharp corners farther in may tell the lens out to the rim: then nobody is sent for more.
TEST(Calibrate, AsksForThePicturesRimWhereTheLensIsNotKnownThere) {
  CalibrationResult result;
  result.cameras.push_back({.name = "cam03", .width = 640, .height = 480});
  CameraQuality quality;
  quality.views = 40;
  quality.corners = 48 * 20;
  quality.coverage.corners.assign(48, 20);
  quality.coverage.outermost_radius = 0.6;
  quality.deviation.rim_px = 0.05;
  result.quality.push_back(quality);
  auto unsure = result;
  judge(result);
  EXPECT_EQ(result.verdict, Verdict::good);
  EXPECT_TRUE(result.quality[0].advice.empty() && result.advice.empty());
  unsure.quality[0].deviation.rim_px = 1.2;
  judge(unsure);
  EXPECT_EQ(unsure.verdict, Verdict::usable);
  EXPECT_THAT(unsure.quality[0].advice, Contains(AllOf(HasSubstr("60 % of the picture's radius"), HasSubstr("1.2 px"),
                                                       HasSubstr("into the corners of its picture"))));
}

// Pictures to cameras, and the wrong board's name for a board that is not there.
TEST(Calibrate, PicturesGiveTheRig) {
  auto rig = tests::board_rig(2, 320, 256, 330.0);
  const BoardPrint print(kBoard);
  rig[1] = tests::camera_at("cam01", {3.0, 1.6, 1.6}, {0, 0, 0.95}, 320, 256, 335.0);
  const std::vector<Eigen::Isometry3d> facing = [&] {
    std::vector<Eigen::Isometry3d> some;
    for (const auto& pose : tests::board_walk(40))
      if (pose.linear().col(2).x() > 0.5 && some.size() < 7) some.push_back(pose);
    return some;
  }();
  std::vector<std::vector<cv::Mat>> pictures(2);
  for (std::size_t camera = 0; camera < 2; ++camera)
    for (const auto& pose : facing)
      pictures[camera].push_back(tests::board_picture(rig[camera], print, pose, {.noise = 1.0}));
  BoardPictures source{.cameras = {"cam00", "cam01"}, .moments = names_of(facing.size())};
  source.grey = [&](std::size_t camera, std::size_t moment) { return pictures[camera][moment]; };
  const auto result = calibrate(source, options());
  ASSERT_EQ(result.cameras.size(), 2U);
  EXPECT_LT(result.rms_px, 0.06);
  EXPECT_NEAR((result.cameras[0].centre() - result.cameras[1].centre()).norm(),
              (rig[0].centre() - rig[1].centre()).norm(), 0.02);
  auto other = options();
  other.boards[0].dictionary = "DICT_6X6_250";
  try {
    calibrate(source, other);
    FAIL() << "a board of other markers was found";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("markers of DICT_4X4_50 instead of DICT_6X6_250"));
  }
  other.boards = {{.type = BoardType::chessboard, .columns = 10, .rows = 7, .square = 0.1, .marker = 0.0}};
  try {
    calibrate(source, other);
    FAIL() << "a chessboard was found";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("markers of DICT_4X4_50"), HasSubstr("ChArUco")));
  }
  other = options();
  other.world_from = "cam07";
  try {
    calibrate(source, other);
    FAIL() << "the world is that of nobody";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("cam07"), HasSubstr("cam00, cam01")));
  }
  for (auto& of_camera : {&pictures[1], &pictures[0]}) {  // one of them, then both
    for (auto& picture : *of_camera) cv::flip(picture, picture, 1);
    try {
      calibrate(source, options());
      FAIL() << "mirrored markers were found";
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("mirrored"));
    }
  }
}

}  // namespace
}  // namespace rotunda::capture
