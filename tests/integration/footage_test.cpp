// Pictures from elsewhere through import, recon and render; and single meshes through map.
#include "tests/integration/footage.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "recon/mesh/mesh_file.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

TEST_F(Footage, WithAMissingCameraIsRefusedWhole) {
  fs::remove_all(images() / "cam02");
  fs::remove(picture_file("cam04", 1));
  const auto outcome = import("ball");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("cam02"), HasSubstr("cam04"), HasSubstr(images().string())));
  EXPECT_TRUE(contents_of(takes()).empty());
}

TEST_F(Footage, OfAnotherSizeIsRefusedWhole) {
  write("cam03", 1, cv::Mat(100, 100, CV_8UC3, cv::Scalar(0, 0, 255)));
  const auto outcome = import("ball");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr(picture_file("cam03", 1).string()), HasSubstr("100"), HasSubstr("180")));
  EXPECT_TRUE(contents_of(takes()).empty());
}

TEST_F(Footage, DoesNotReplaceATake) {
  ASSERT_EQ(import("ball").exit_code, 0);
  const auto before = contents_of(takes());
  const auto outcome = import("ball");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr((takes() / "ball").string() + " exists already"));
  EXPECT_EQ(contents_of(takes()), before);
}

TEST_F(Footage, WithACalibrationThatLacksACameraIsNotReconstructed) {
  ASSERT_EQ(import("ball").exit_code, 0);
  const auto before = contents_of(takes());
  auto fewer = cameras_;
  fewer.erase(fewer.begin() + 2);
  capture::write_calibration(folder() / "fewer.yaml", fewer);
  const auto lacking = recon("ball", {"--calibration", (folder() / "fewer.yaml").string()});
  EXPECT_EQ(lacking.exit_code, 3);
  EXPECT_THAT(lacking.err, AllOf(HasSubstr("cam02"), HasSubstr("fewer.yaml")));
  auto other = cameras_;
  other[4].width += 10;
  capture::write_calibration(folder() / "other.yaml", other);
  const auto of_other_size = recon("ball", {"--calibration", (folder() / "other.yaml").string()});
  EXPECT_EQ(of_other_size.exit_code, 3);
  EXPECT_THAT(of_other_size.err,
              AllOf(HasSubstr("cam04"), HasSubstr("180"), HasSubstr("190"), HasSubstr("other.yaml")));
  EXPECT_EQ(contents_of(takes()), before);
}

TEST_F(Footage, WithAnEmptySilhouetteFailsThatFrameByName) {
  write("cam01", 1, cv::Mat(144, 180, CV_8UC3, cv::Scalar(kBlue[0], kBlue[1], kBlue[2])));
  ASSERT_EQ(import("ball").exit_code, 0);
  const auto outcome = recon("ball");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  const auto report = json::parse(outcome.out);
  EXPECT_EQ(report["mapped"], 1) << outcome.out;
  ASSERT_EQ(report["failed"].size(), 1u) << outcome.out;
  EXPECT_EQ(report["failed"][0]["frame"], 1);
  EXPECT_THAT(report["failed"][0]["reason"], AllOf(HasSubstr("cam01"), HasSubstr("empty")));

  const auto only_that = recon("ball", {"--frames", "1:2"});
  EXPECT_EQ(only_that.exit_code, 3);
  EXPECT_THAT(only_that.err, HasSubstr("cam01"));
}

double overlap(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero(a & b)) / cv::countNonZero(a | b);
}

TEST_F(Footage, ComesBackInTheCamerasOwnViews) {
  ASSERT_EQ(import("ball").exit_code, 0);
  const auto meshes = folder() / "meshes", mattes = folder() / "mattes";
  const auto outcome = recon("ball", {"--meshes", meshes.string(), "--mattes", mattes.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["mapped"], kFrames);
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_GT(recon::read_ply(meshes / fmt::format("frame{:06}.ply", frame)).triangles.size(), 500u);
  for (const auto* camera : {"cam00", "cam05"}) {
    const auto picture = folder() / (std::string(camera) + ".png");
    const auto rendered = rotunda(
        {"render", "ball", "--view", calibration().string() + ":" + camera, "--frame", "1", "-o", picture.string()});
    ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
    const cv::Mat drawn = cv::imread(picture.string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(drawn.size(), cv::Size(180, 144));
    ASSERT_EQ(drawn.channels(), 4);
    cv::Mat alpha;
    cv::extractChannel(drawn, alpha, 3);
    const cv::Mat matte = capture::read_grey(mattes / camera / "frame000001.png");
    EXPECT_GE(overlap(alpha >= 128, matte >= 128), 0.9) << camera;  // cells of 30 mm on a ball of 1 m
  }
}

TEST_F(Footage, IsDrawnInItsOwnPicturesColours) {
  ASSERT_EQ(import("ball").exit_code, 0);
  ASSERT_EQ(recon("ball").exit_code, 0);
  const auto picture = folder() / "view.png";
  const auto rendered = rotunda({"render", "ball", "--view", calibration().string() + ":cam00", "--frame", "1",
                                 "--view-dependent", "-o", picture.string()});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const cv::Mat drawn = cv::imread(picture.string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(drawn.channels(), 4);
  cv::Mat bgr, inside, alpha;
  cv::cvtColor(drawn, bgr, cv::COLOR_BGRA2BGR);
  cv::extractChannel(drawn, alpha, 3);
  cv::erode(alpha == 255, inside, cv::Mat::ones(9, 9, CV_8UC1));  // away from the outline
  const double rms = cv::norm(bgr, cv::imread(picture_file("cam00", 1).string()), cv::NORM_L2, inside) /
                     std::sqrt(3.0 * cv::countNonZero(inside));
  EXPECT_LT(rms, 6.0);  // it is that camera's picture: stripes of the stored colours, 30 mm apart, miss it by 30

  // Without its take there are no pictures, and nothing is left where a folder of them was asked for.
  const auto clip = takes() / "ball" / "recon" / "geometry.mkv", nothing = folder() / "nothing";
  const auto refused = rotunda({"render", clip.string(), "--view", calibration().string() + ":cam00",
                                "--view-dependent", "-o", nothing.string()});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("geometry.mkv"), HasSubstr("take")));
  EXPECT_FALSE(fs::exists(nothing));
  auto fewer = cameras_;
  fewer.pop_back();
  capture::write_calibration(folder() / "fewer.yaml", fewer);
  const auto lacking = rotunda({"render", "ball", "--view-dependent", "--frame", "0", "--calibration",
                                (folder() / "fewer.yaml").string(), "-o", picture.string()});
  EXPECT_EQ(lacking.exit_code, 3);
  EXPECT_THAT(lacking.err, AllOf(HasSubstr("cam05"), HasSubstr("fewer.yaml")));
}

TEST_F(Footage, IsReconstructedFurtherAfterCtrlC) {
  constexpr int kMany = 6;
  for (int frame = kFrames; frame < kMany; ++frame)
    for (const auto& camera : cameras_) fs::copy_file(picture_file(camera.name, 0), picture_file(camera.name, frame));
  ASSERT_EQ(import("ball").exit_code, 0);
  const std::vector<std::string> arguments{"--takes", takes().string(), "recon",       "ball", "--quality", "live",
                                           "--cell",  "30mm",           "--triangles", "2000", "--jobs",    "1"};
  const auto first = start("rotunda", arguments);
  const auto stored = takes() / "ball" / "recon" / "frames" / "frame000000.ply";
  while (first->running() && !fs::exists(stored)) usleep(10'000);
  first->send(SIGINT);
  EXPECT_EQ(first->wait(), 1) << first->err();
  EXPECT_THAT(first->err(), HasSubstr("goes on where it stopped"));
  EXPECT_FALSE(fs::exists(takes() / "ball" / "recon" / "geometry.mkv"));
  const auto second = recon("ball");
  EXPECT_EQ(second.exit_code, 0) << second.err;
  const auto report = json::parse(second.out);
  EXPECT_EQ(report["mapped"], kMany);
  EXPECT_GE(report["resumed"], 1);
  EXPECT_LT(report["resumed"], kMany);
}

class Map : public HouseTest {};

TEST_F(Map, TakesAClosedMeshToTheSphereAndBack) {
  const auto file = folder() / "ball.ply", remesh = folder() / "remesh.ply", image = folder() / "image.png";
  recon::write_ply(file, icosphere(3));
  const auto outcome =
      rotunda({"map", file.string(), "--level", "5", "--remesh", remesh.string(), "-o", image.string(), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["flips"], 0);
  for (const auto& position : recon::read_ply(remesh).positions)
    EXPECT_NEAR(position.norm(), 1.0f, 0.01f);  // flat triangles of 8 degrees lie 0.002 inside
  EXPECT_EQ(capture::read_rgb(image).size(), cv::Size(33, 33));
}

TEST_F(Map, SaysWhyAnOpenMeshOrAnotherFileCannotBeMapped) {
  auto open = icosphere(2);
  open.triangles.pop_back();
  const auto file = folder() / "open.ply";
  recon::write_ply(file, open);
  const auto of_open = rotunda({"map", file.string(), "--remesh", (folder() / "remesh.ply").string()});
  EXPECT_EQ(of_open.exit_code, 3);
  EXPECT_THAT(of_open.err, AllOf(HasSubstr(file.string()), HasSubstr("closed")));
  EXPECT_FALSE(fs::exists(folder() / "remesh.ply"));

  auto flat = icosphere(2);
  flat.positions[flat.triangles[5][0]] = flat.positions[flat.triangles[5][1]];
  recon::write_ply(file, flat);
  const auto of_flat = rotunda({"map", file.string()});
  EXPECT_EQ(of_flat.exit_code, 3);
  EXPECT_THAT(of_flat.err, AllOf(HasSubstr(file.string()), HasSubstr("has no area")));

  const auto text = folder() / "notes.txt";
  std::ofstream(text) << "not a mesh\n";
  const auto of_text = rotunda({"map", text.string()});
  EXPECT_EQ(of_text.exit_code, 3);
  EXPECT_THAT(of_text.err, HasSubstr(text.string()));
  EXPECT_EQ(text_of(text), "not a mesh\n");
  const auto of_none = rotunda({"map", (folder() / "none.ply").string()});
  EXPECT_THAT(of_none.err, HasSubstr((folder() / "none.ply").string()));
  EXPECT_THAT(of_none.exit_code, testing::AnyOf(3, 4));
}

}  // namespace
}  // namespace rotunda::tests
