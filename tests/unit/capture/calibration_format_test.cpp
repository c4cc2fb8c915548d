#include "capture/calibration/calibration_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>

#include "capture/calibration/projection_matrix.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr CalibrationFormat kAll[] = {CalibrationFormat::opencv, CalibrationFormat::json,
                                      CalibrationFormat::projections, CalibrationFormat::colmap};

// A ring of cameras that look at the middle, with everything a camera can have.
CalibrationFile ring(int cameras, bool distorted, bool skewed) {
  CalibrationFile calibration{.unit = "m", .cameras = {}};
  for (int i = 0; i < cameras; ++i) {
    const double angle = 2.0 * M_PI * i / cameras;
    CameraModel camera;
    camera.name = "cam" + std::to_string(i);
    camera.width = 720 + i;
    camera.height = 576;
    camera.K << 801.0 / 0.7 + i, skewed ? 0.3 : 0.0, 361.1, 0, 903.0 / 0.7, 281.7, 0, 0, 1;
    if (distorted) camera.distortion << -0.21, 0.07, 1.0 / 3000.0, -2e-4, 0.011;
    const Eigen::Vector3d centre(3.1 * std::cos(angle), 3.3 * std::sin(angle), 1.7);
    const Eigen::Vector3d z = (Eigen::Vector3d(0, 0.1, 0.9) - centre).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    camera.R << x.transpose(), z.cross(x).transpose(), z.transpose();
    camera.t = -camera.R * centre;
    calibration.cameras.push_back(camera);
  }
  return calibration;
}

class CalibrationFormatTest : public ::testing::Test {
 protected:
  fs::path place(CalibrationFormat format) const {
    const std::string name(to_string(format));
    switch (format) {
      case CalibrationFormat::opencv:
        return folder_.path() / (name + ".yaml");
      case CalibrationFormat::json:
        return folder_.path() / (name + ".json");
      case CalibrationFormat::projections:
        return folder_.path() / (name + ".txt");
      default:
        return folder_.path() / name;
    }
  }
  fs::path write(CalibrationFormat format, const CalibrationFile& calibration) const {
    write_any_calibration(place(format), calibration, format);
    return place(format);
  }
  fs::path store(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }
  static ImportedCalibration read(const fs::path& file) { return read_any_calibration(file, format_of_file(file)); }
  static std::string refusal(const std::function<void()>& read_it) {
    try {
      read_it();
    } catch (const ConfigError& error) {
      return error.what();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }

  TemporaryFolder folder_;
};

void expect_same(const CalibrationFile& a, const CalibrationFile& b, const std::string& what) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size()) << what;
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const auto &one = a.cameras[i], &other = b.cameras[i];
    EXPECT_EQ(one.name, other.name) << what;
    EXPECT_EQ(one.width, other.width) << what;
    EXPECT_EQ(one.height, other.height) << what;
    EXPECT_LT((one.K - other.K).cwiseAbs().maxCoeff(), 1e-9) << what << "\n" << one.K << "\n" << other.K;
    EXPECT_LT((one.distortion - other.distortion).cwiseAbs().maxCoeff(), 1e-15) << what;
    EXPECT_LT((one.R - other.R).cwiseAbs().maxCoeff(), 1e-12) << what;
    EXPECT_LT((one.t - other.t).cwiseAbs().maxCoeff(), 1e-11) << what;
  }
}

TEST_F(CalibrationFormatTest, ARoundTripThroughEachChangesNothing) {
  for (const auto format : kAll) {
    const bool pinhole_only = format == CalibrationFormat::projections;
    const auto rig = ring(5, !pinhole_only, format != CalibrationFormat::colmap);
    EXPECT_TRUE(losses_in(rig, format).empty());
    const auto file = write(format, rig);
    EXPECT_EQ(format_of_file(file), format);
    EXPECT_EQ(format_of_name(file), format);
    expect_same(rig, read(file).calibration, std::string(to_string(format)));
  }
}

TEST_F(CalibrationFormatTest, WhatAFormatCannotHoldIsNamed) {
  const auto rig = ring(3, true, true);
  EXPECT_THAT(losses_in(rig, CalibrationFormat::projections).at(2), HasSubstr("cam2"));
  EXPECT_THAT(losses_in(rig, CalibrationFormat::colmap).at(0), HasSubstr("skew"));
  EXPECT_TRUE(losses_in(rig, CalibrationFormat::json).empty());
}

TEST_F(CalibrationFormatTest, ProjectionMatricesOfAnyScaleAndSignAreTheSameCameras) {
  const auto rig = ring(6, false, true);
  std::vector<ProjectionMatrix> matrices;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const double scale = (i % 2 == 0 ? -1.0 : 1.0) * std::pow(10.0, 3.0 * static_cast<double>(i) - 8.0);
    matrices.push_back(scale * projection_matrix(rig.cameras[i]));
    names.push_back(rig.cameras[i].name);
  }
  const auto set = decompose(matrices, names);
  EXPECT_EQ(set.handedness, Handedness::right);
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    EXPECT_LT((set.cameras[i].K - rig.cameras[i].K).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((set.cameras[i].t - rig.cameras[i].t).cwiseAbs().maxCoeff(), 1e-11);
  }
}

TEST_F(CalibrationFormatTest, ALeftHandedSetIsKnownByWhatTheCamerasLookAt) {
  auto rig = ring(6, false, true);
  mirror_world(rig);
  const auto imported = read(write(CalibrationFormat::projections, rig));
  expect_same(rig, imported.calibration, "mirrored");
  ASSERT_EQ(imported.notes.size(), 1U);
  EXPECT_THAT(imported.notes[0], HasSubstr("left-handed"));
  EXPECT_THAT(refusal([&] { write(CalibrationFormat::colmap, rig); }), HasSubstr("--mirror"));
  mirror_world(rig);
  expect_same(rig, ring(6, false, true), "mirrored twice");
}

TEST_F(CalibrationFormatTest, MatricesOfTwoWorldsAreRefusedByCamera) {
  auto rig = ring(6, false, false);
  rig.cameras[4].R.row(0) *= -1.0;  // a picture that was flipped
  rig.cameras[4].t[0] *= -1.0;
  EXPECT_THAT(refusal([&] { read(write(CalibrationFormat::projections, rig)); }), HasSubstr("cam4"));
}

TEST_F(CalibrationFormatTest, DataSetsFormsOfMatricesAreRead) {
  const auto one_each = store("contours/left.txt", "CONTOUR\n-500 0 -320 0\n0 -500 -240 0\n0 0 -1 -3\n");
  store("contours/right.P", "500 0 320 -250\n0 500 240 0\n0 0 1 3\n");
  const auto folder = read(one_each.parent_path()).calibration;
  ASSERT_EQ(folder.cameras.size(), 2U);
  EXPECT_EQ(folder.cameras[1].name, "right");
  EXPECT_NEAR(folder.cameras[0].K(0, 2), 320.0, 1e-9);
  EXPECT_NEAR(folder.cameras[1].t.z(), 3.0, 1e-12);

  const auto parts =
      read(store("middlebury.txt", "1\ntemple0001.png 1500 0 300 0 1500 240 0 0 1 1 0 0 0 1 0 0 0 1 0.1 0.2 0.6\n"));
  EXPECT_EQ(parts.calibration.cameras.at(0).name, "temple0001");
  EXPECT_NEAR(parts.calibration.cameras.at(0).t.y(), 0.2, 1e-12);
  EXPECT_NEAR(parts.calibration.cameras.at(0).K(1, 2), 240.0, 1e-9);
}

TEST_F(CalibrationFormatTest, ColmapCountsPixelsFromTheCorner) {
  store("model/cameras.txt",
        "# comment\n1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n2 RADIAL 640 480 500 320 240 -0.1 0.02\n");
  store("model/images.txt", "1 1 0 0 0 0 0 3 1 left/a b.png\n12.5 13.5 -1 4 5 7\n2 0 0 0 2 0 0 3 2 right/a b.png\n\n");
  const auto cameras = read(folder_.path() / "model").calibration.cameras;
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[0].name, "left");
  EXPECT_EQ(cameras[0].K(0, 2), 319.5);
  EXPECT_EQ(cameras[0].K(1, 2), 239.5);
  EXPECT_EQ(cameras[1].distortion[1], 0.02);
  EXPECT_NEAR(cameras[1].R(0, 0), -1.0, 1e-15);  // half a turn about z, the quaternion of length 2
}

TEST_F(CalibrationFormatTest, OtherProgramsJsonIsRead) {
  const auto camera = std::string(R"("K":[500,0,320,0,500,240,0,0,1],"distCoef":[0.1,0,0,0],"t":[[1],[2],[3]])");
  const auto file =
      store("studio.json",
            "{\"cameras\":{\"a\":{\"resolution\":[640,480],\"rvec\":[0,0,1.5707963267948966]," + camera + "}}}");
  const auto cameras = read(file).calibration.cameras;
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].name, "a");
  EXPECT_EQ(cameras[0].distortion[0], 0.1);
  EXPECT_NEAR(cameras[0].R(1, 0), 1.0, 1e-15);
  EXPECT_EQ(cameras[0].t.z(), 3.0);
}

TEST_F(CalibrationFormatTest, SizesComeFromPicturesOrByHandOrAreAskedFor) {
  auto unknown = ring(2, false, false);
  for (auto& camera : unknown.cameras) camera.width = camera.height = 0;
  auto by_hand = unknown;
  complete_sizes(by_hand, {}, std::pair{640, 480});
  EXPECT_EQ(by_hand.cameras[1].height, 480);
  EXPECT_THAT(refusal([&] { complete_sizes(unknown, {}, std::nullopt); }), HasSubstr("cam0, cam1"));
}

// Every mistake names file, line or key.
TEST_F(CalibrationFormatTest, RefusalsNameThePlace) {
  const auto says = [&](const std::string& name, const std::string& text, const std::string& place) {
    const auto file = store(name, text);
    EXPECT_THAT(refusal([&] { read(name.find('/') == std::string::npos ? file : file.parent_path()); }),
                HasSubstr(place))
        << text;
  };
  says("a.json", R"({"cameras":[{"name":"x","K":[1,2],"R":[],"t":[0,0,0]}]})", "cameras[0] (x).K");
  says("b.json", R"({"cameras":[)", "line 1");
  says("c.json", R"([{"name":"x","K":[5,0,1,0,5,1,0,0,1],"R":[1,0,0,0,1,0,0,0,2],"t":[0,0,0]}])", "(root)[0] (x).R");
  says("d.json",
       R"([{"name":"x","K":[5,0,1,0,5,1,0,0,1],"dist":[0,0,0,0,0,1,0,0],"R":[1,0,0,0,1,0,0,0,1],"t":[0,0,0]}])",
       "k4 = 1");
  says("a.txt", "cam0 1 2 3 4 5 6 7 8 9 10 x 12\n", "a.txt:1:27");
  says("b.txt", "# no\ncam0\n1 0 0 0\n0 1 0 0\n", "after 8 of 12");
  says("c.txt", "cam0 1 2 3 4 1 2 3 4 1 2 3 4\n", "no centre");
  says("d.txt", "", "no projection matrix");
  store("m/cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n");
  says("m/images.txt", "1 0 0 0 0 0 0 3 1 a.png\n\n", "no direction");
  says("m/images.txt", "1 1 0 0 0 0 0 3 9 a.png\n\n", "no camera 9");
  says("m/images.txt", "1 1 0 0 0 0 0 3 1 a.png\n\n2 1 0 0 0 0 0 3 1 a.jpg\n\n", "images.txt:3:");
  says("n/cameras.txt", "1 OPENCV_FISHEYE 640 480 500 500 320 240 0 0 0 0\n", "cameras.txt:1:3");
  says("o/cameras.txt", "1 FULL_OPENCV 640 480 500 500 320 240 0 0 0 0 0 0.1 0 0\n", "k4");
}

// A flipped bit or a cut end is read as something or refused; never a crash, never a camera that cannot be computed
// with.
TEST_F(CalibrationFormatTest, DamagedFilesAreReadOrRefused) {
  std::mt19937 random(5);
  for (const auto format : kAll) {
    auto file = write(format, ring(3, format != CalibrationFormat::projections, false));
    const bool folder = fs::is_directory(file);
    for (const auto* part : {"cameras.txt", "images.txt"}) {
      const auto damaged = folder ? file / part : file;
      std::ifstream stream(damaged, std::ios::binary);
      const std::string whole{std::istreambuf_iterator<char>(stream), {}};
      for (int i = 0; i < 90; ++i) {
        std::string text = whole;
        const std::size_t at = random() % text.size();
        if (i % 3 == 0)
          text.resize(at);
        else
          text[at] = static_cast<char>(text[at] ^ (1 << (random() % 8)));
        std::ofstream(damaged, std::ios::binary) << text;
        try {
          for (const auto& camera : read_any_calibration(file, format).calibration.cameras) {
            EXPECT_TRUE(camera.K.allFinite() && camera.R.allFinite() && camera.t.allFinite());
            EXPECT_NEAR(std::abs(camera.R.determinant()), 1.0, 1e-6);
          }
        } catch (const ConfigError& error) {
          EXPECT_FALSE(error.problems().empty());
        }
      }
      std::ofstream(damaged, std::ios::binary) << whole;
      if (!folder) break;
    }
  }
}

}  // namespace
}  // namespace rotunda::capture
