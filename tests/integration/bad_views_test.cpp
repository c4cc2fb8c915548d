// Takes whose views cannot give a surface, or nearly not: each is told in one sentence, and what can be is made.
#include <fstream>
#include <opencv2/core.hpp>

#include "tests/integration/footage.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class BadViews : public Footage {
 protected:
  // With the same matte for every picture of every camera.
  Outcome import_with_mattes(double alpha) {
    const auto mattes = folder() / "mattes";
    for (const auto& camera : cameras_) {
      fs::create_directories(mattes / camera.name);
      for (int frame = 0; frame < kFrames; ++frame)
        capture::write_png(mattes / camera.name / fmt::format("{:03}.png", frame),
                           cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(alpha)));
    }
    return rotunda({"take", "import", "ball", "--images", images().string(), "--calibration", calibration().string(),
                    "--mattes", mattes.string()});
  }
  // From now on the calibration has it turned about its own centre.
  void turn(std::size_t camera, double degrees, const Eigen::Vector3d& axis) {
    const Eigen::Matrix3d by = Eigen::AngleAxisd(degrees * M_PI / 180.0, axis).matrix();
    cameras_[camera].R = by * cameras_[camera].R;
    cameras_[camera].t = by * cameras_[camera].t;
    capture::write_calibration(calibration(), cameras_);
  }
  void expect_no_frame(const Outcome& outcome, const std::string& why) {
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why));
    const auto report = json::parse(outcome.out);
    EXPECT_EQ(report["mapped"], 0);
    EXPECT_EQ(report["failed"].size(), static_cast<std::size_t>(kFrames));
  }
};

TEST_F(BadViews, WithoutOverlapHaveNoPointInCommon) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) turn(i, 180.0, Eigen::Vector3d::UnitY());  // all look outwards
  ASSERT_EQ(import("ball").exit_code, 0);
  expect_no_frame(recon("ball"), "check that calibration and mattes");
}

TEST_F(BadViews, WithEmptyMattesAreNamed) {
  ASSERT_EQ(import_with_mattes(0.0).exit_code, 0);
  expect_no_frame(recon("ball"), "empty silhouette in cam00, cam01, cam02, cam03, cam04, cam05");
}

TEST_F(BadViews, WithFullMattesHaveNoBackdrop) {
  ASSERT_EQ(import_with_mattes(255.0).exit_code, 0);
  expect_no_frame(recon("ball"), "the key found no backdrop");
}

TEST_F(BadViews, OfACameraTwoDegreesOffCostNoFrameAndNameIt) {
  constexpr int kPlaces = 8;  // a ball that moves tells more than one that stands still
  for (int frame = 0; frame < kPlaces; ++frame) {
    const double angle = 2.0 * M_PI * frame / kPlaces;
    const Ball ball{.centre = {0.5 * std::cos(angle), 0.4 * std::sin(angle), 0.7 + 0.05 * frame}, .radius = 0.3};
    for (const auto& camera : cameras_)
      write(camera.name, frame, picture_of(camera, std::span(&ball, 1), kBlue, [](auto, const auto&) {
                                  return cv::Vec3f(220, 180, 60);
                                }).rgb);
  }
  turn(3, 2.0, Eigen::Vector3d::UnitY());
  ASSERT_EQ(import("ball").exit_code, 0);
  const auto outcome = recon("ball");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["mapped"], kPlaces);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("cam03"), HasSubstr("calibrate anew")));
}

TEST_F(BadViews, OfAnotherVolumeTellWhereTheyMeet) {
  ASSERT_EQ(import("ball").exit_code, 0);
  std::ofstream rig(takes() / "ball" / "rig.yaml");
  rig << "name: elsewhere\nvolume: { min: [0.9, 0.6, 0.0], max: [1.5, 1.0, 2.0] }\ncameras:\n";
  for (std::size_t i = 0; i < cameras_.size(); ++i)
    rig << fmt::format("  - {{ name: {}, address: 127.0.0.{} }}\n", cameras_[i].name, i + 1);
  rig.close();
  expect_no_frame(recon("ball"), "which meet between (-0.");
}

}  // namespace
}  // namespace rotunda::tests
