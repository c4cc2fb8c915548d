#include "capture/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/core/persistence.hpp>
#include <sstream>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using ::testing::HasSubstr;

class CalibrationFileTest : public ::testing::Test {
 protected:
  CalibrationFileTest()
      : file_(std::filesystem::path(::testing::TempDir()) /
              (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml")) {}
  ~CalibrationFileTest() override { std::filesystem::remove(file_); }

  void store(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }
  std::string stored() const {
    std::ifstream stream(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  // The message of the refusal; fails if the text is accepted.
  std::string refusal(const std::string& text) const {
    store(text);
    try {
      read_calibration(file_);
    } catch (const ConfigError& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted:\n" << text;
    return {};
  }

  const std::filesystem::path file_;
};

CameraModel odd_camera(const std::string& name, double angle) {
  CameraModel camera;
  camera.name = name;
  camera.width = 720;
  camera.height = 576;
  camera.K << 801.0 / 7.0, 0.3, 361.1, 0, 903.0 / 7.0, 281.7, 0, 0, 1;
  camera.distortion << -0.21, 0.07, 1.0 / 3000.0, -2e-4, 0.011;
  camera.R = Eigen::AngleAxisd(angle, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  camera.t << 0.1, -1.0 / 3.0, 4.7;
  camera.rms_px = 0.123456789012345;
  return camera;
}

// One plain camera as a person would write it, a line replaced or dropped at will.
std::string plain(const std::string& key = {}, const std::string& replacement = {}) {
  std::string text = "%YAML:1.0\n---\nunit: \"m\"\ncameras:\n";
  const std::pair<const char*, const char*> lines[] = {{"name", "name: cam00"},
                                                       {"image_size", "image_size: [ 64, 48 ]"},
                                                       {"K", "K: [ 50, 0.5, 31.5, 0, 53, 23.5, 0, 0, 1 ]"},
                                                       {"distortion", "distortion: [ 0, 0, 0, 0, 0 ]"},
                                                       {"R", "R: [ [ 1, 0, 0 ], [ 0, 1, 0 ], [ 0, 0, 1 ] ]"},
                                                       {"t", "t: [ 0, 0, 3 ]"}};
  text += "   - rms_px: 0.25\n";
  for (const auto& [name, line] : lines) {
    const std::string written = name == key ? replacement : line;
    if (!written.empty()) text += "     " + written + "\n";
  }
  return text;
}

TEST_F(CalibrationFileTest, ColourIsKeptWhereThereIsOne) {
  CalibrationFile calibration{"m", {odd_camera("cam00", 0.4), odd_camera("cam01", 2.9)}, {}};
  calibration.colour["cam01"] << 1.1, 0.02, 0, -0.01, 0.97, 1.0 / 3.0, 0, 0, 0.9;
  write_calibration(file_, calibration);
  const auto read = read_calibration_file(file_);
  EXPECT_EQ(read.colour, calibration.colour);
  EXPECT_TRUE(read.colour_of("cam00").isIdentity(0.0));
  EXPECT_THAT(refusal(plain("t", "t: [ 0, 0, 3 ]\n     colour: [ 1, 0, 0, 0, 1, 0, 1, 0, 0 ]")),
              HasSubstr("cameras[0].colour (cam00)"));
}

TEST_F(CalibrationFileTest, EveryNumberSurvivesTheRoundTrip) {
  const std::vector<CameraModel> cameras{odd_camera("cam00", 0.4), odd_camera("left one", 2.9)};
  write_calibration(file_, cameras);
  const auto again = read_calibration_file(file_);
  EXPECT_EQ(again.unit, "m");
  ASSERT_EQ(again.cameras.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.cameras[i].name, cameras[i].name);
    EXPECT_EQ(again.cameras[i].width, 720);
    EXPECT_EQ(again.cameras[i].height, 576);
    EXPECT_EQ(again.cameras[i].K, cameras[i].K);
    EXPECT_EQ(again.cameras[i].distortion, cameras[i].distortion);
    EXPECT_EQ(again.cameras[i].R, cameras[i].R);
    EXPECT_EQ(again.cameras[i].t, cameras[i].t);
    EXPECT_EQ(again.cameras[i].rms_px, cameras[i].rms_px);
  }
}

TEST_F(CalibrationFileTest, OpenCvReadsWhatIsWritten) {
  write_calibration(file_, std::vector<CameraModel>{odd_camera("cam00", 0.4)});
  cv::FileStorage storage(file_.string(), cv::FileStorage::READ);
  ASSERT_TRUE(storage.isOpened());
  EXPECT_EQ(storage["unit"].string(), "m");
  const cv::FileNode camera = storage["cameras"][0];
  cv::Mat K, t, distortion;
  camera["K"] >> K;
  camera["t"] >> t;
  camera["distortion"] >> distortion;
  EXPECT_EQ(camera["name"].string(), "cam00");
  EXPECT_EQ(static_cast<int>(camera["image_size"][1]), 576);
  ASSERT_EQ(K.size(), cv::Size(3, 3));
  EXPECT_DOUBLE_EQ(K.at<double>(0, 1), 0.3);
  ASSERT_EQ(t.size(), cv::Size(1, 3));
  EXPECT_DOUBLE_EQ(t.at<double>(2), 4.7);
  ASSERT_EQ(distortion.size(), cv::Size(5, 1));
}

TEST_F(CalibrationFileTest, ReadsPlainSequencesAndKeepsAForeignUnit) {
  std::string text = plain();
  text.replace(text.find("\"m\""), 3, "mm");
  store(text);
  const auto calibration = read_calibration_file(file_);
  EXPECT_EQ(calibration.unit, "mm");
  EXPECT_EQ(calibration.cameras[0].K(0, 1), 0.5);
  EXPECT_EQ(calibration.cameras[0].t.z(), 3.0);
  EXPECT_EQ(calibration.cameras[0].rms_px, 0.25);
  store(plain("distortion", ""));
  EXPECT_TRUE(read_calibration(file_)[0].distortion.isZero(0.0));
}

TEST_F(CalibrationFileTest, KeepsAMirroredWorldAsItIs) {
  CameraModel mirrored = odd_camera("cam00", 1.0);
  mirrored.R.col(2) *= -1.0;  // the world's z turned round: det(R) = -1
  write_calibration(file_, std::vector<CameraModel>{mirrored});
  EXPECT_EQ(read_calibration(file_)[0].R, mirrored.R);
}

TEST_F(CalibrationFileTest, ANegativeFocalLengthProjectsAsWrittenAfterItsSignMovedIntoThePose) {
  CameraModel truth = odd_camera("cam00", 0.2);
  CameraModel turned = truth;  // the same pictures with y up in the camera
  const Eigen::Vector3d flip(1, -1, 1);
  turned.K = truth.K * flip.asDiagonal();
  turned.R = flip.asDiagonal() * truth.R;
  turned.t = flip.asDiagonal() * truth.t;
  turned.distortion[2] *= -1.0;
  write_calibration(file_, std::vector<CameraModel>{turned});
  const auto read = read_calibration(file_)[0];
  EXPECT_GT(read.K(1, 1), 0.0);
  const Eigen::Vector3d point(0.2, -0.1, 0.3);
  const auto expected = project(truth, point), found = project(read, point);
  ASSERT_TRUE(expected && found);
  EXPECT_LT((*expected - *found).norm(), 1e-9);
}

TEST_F(CalibrationFileTest, MakesARoundedRotationOrthonormal) {
  store(plain("R", "R: [ 0.6000, -0.8001, 0, 0.8, 0.6, 0, 0, 0, 1 ]"));
  const Eigen::Matrix3d R = read_calibration(file_)[0].R;
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(R(0, 0), 0.6, 2e-4);
}

TEST_F(CalibrationFileTest, LensesAloneNeedNoPoses) {
  const std::string lens =
      "cameras:\n  - name: cam00\n    image_size: [64, 48]\n    K: [50, 0, 31, 0, 53, 23, 0, 0, 1]\n";
  store(lens);
  EXPECT_THROW(read_calibration(file_), ConfigError);
  const auto lenses = read_lenses(file_);
  ASSERT_EQ(lenses.size(), 1U);
  EXPECT_EQ(lenses[0].K(1, 1), 53.0);
  EXPECT_TRUE(lenses[0].R.isIdentity(0.0) && lenses[0].t.isZero(0.0));
  store(lens + "    t: [0, 0, 1]\n");  // half a pose is a mistake
  EXPECT_THROW(read_lenses(file_), ConfigError);
}

TEST_F(CalibrationFileTest, NamesTheMistake) {
  const std::tuple<const char*, const char*, const char*> mistakes[] = {
      {"name", "", "cameras[0].name: is missing"},
      {"name", "name: ../etc", "cameras[0].name: expected a name"},
      {"image_size", "", "cameras[0].image_size (cam00): is missing"},
      {"image_size", "image_size: [ 64 ]", "expected 2 numbers, found 1"},
      {"image_size", "image_size: [ -64, 48 ]", "whole pixels"},
      {"K", "", "cameras[0].K (cam00): is missing"},
      {"K", "K: [ 50, 0, 31, 1, 53, 23, 0, 0, 1 ]", "upper triangular"},
      {"K", "K: [ 0, 0, 31, 0, 53, 23, 0, 0, 1 ]", "focal lengths must not be zero"},
      {"K", "K: [ 50, 0, .nan, 0, 53, 23, 0, 0, 1 ]", "finite"},
      {"K", "K: [ 50, 0, x, 0, 53, 23, 0, 0, 1 ]", "expected a 3 x 3 matrix"},
      {"K", "K: !!opencv-matrix { rows: 2, cols: 3, dt: d, data: [ 1, 2, 3, 4, 5, 6 ] }", "found 2 x 3"},
      {"K", "K: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 1, 2, 3 ] }", "found 3 numbers"},
      {"distortion", "distortion: [ 1, 2 ]", "cameras[0].distortion (cam00): expected 5 numbers"},
      {"R", "R: [ 1, 0, 0, 0, 1, 0, 0, 0, 2 ]", "cameras[0].R (cam00): expected a rotation"},
      {"t", "t: [ .inf, 0, 0 ]", "cameras[0].t (cam00): every number must be finite"},
      {"t", "t: { a: 1 }", "expected 3 numbers"},
  };
  for (const auto& [key, line, message] : mistakes) {
    const std::string said = refusal(plain(key, line));
    EXPECT_THAT(said, HasSubstr(message)) << line;
    EXPECT_THAT(said, HasSubstr(file_.string()));
  }
}

TEST_F(CalibrationFileTest, SaysEveryMistakeAtOnceWithItsLine) {
  store(plain("R", "R: [ 1, 2 ]") + "   - name: cam00\n");
  try {
    read_calibration(file_);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    ASSERT_EQ(error.problems().size(), 5U);  // R of the first; image_size, K, R, t of the second
    EXPECT_EQ(error.problems()[0].line, 10);
    EXPECT_EQ(error.problems()[0].key, "cameras[0].R (cam00)");
  }
}

TEST_F(CalibrationFileTest, RefusesWhatIsNoCalibration) {
  EXPECT_THAT(refusal(""), HasSubstr("is this a calibration file?"));
  EXPECT_THAT(refusal("%YAML:1.0\n---\nunit: \"m\"\n"), HasSubstr("at least one camera"));
  EXPECT_THAT(refusal("%YAML:1.0\n---\ncameras: [ ]\n"), HasSubstr("at least one camera"));
  EXPECT_THAT(refusal("cameras: [ { name: a\n"), HasSubstr("is not YAML"));
  EXPECT_THAT(refusal(std::string(100000, '[')), HasSubstr("is not YAML"));
  EXPECT_THAT(refusal(plain() + plain().substr(plain().find("   - "))), HasSubstr("cam00 is used twice"));
  std::filesystem::remove(file_);
  EXPECT_THROW(read_calibration(file_), ConfigError);
  EXPECT_THROW(read_calibration(::testing::TempDir()), ConfigError);
}

TEST_F(CalibrationFileTest, SurvivesTruncationsAndFlippedBytes) {
  write_calibration(file_, std::vector<CameraModel>{odd_camera("cam00", 0.4)});
  const std::string whole = stored();
  std::size_t offered = 0, refused = 0;
  const auto offer = [&](const std::string& text) {
    store(text);
    ++offered;
    try {
      for (const auto& camera : read_calibration(file_)) {  // what is accepted is a camera one can compute with
        EXPECT_TRUE(camera.K.allFinite() && camera.R.allFinite() && camera.t.allFinite());
        EXPECT_GT(camera.width * camera.height, 0);
      }
    } catch (const ConfigError&) {
      ++refused;
    }
  };
  for (std::size_t length = 0; length < whole.size(); length += 11) offer(whole.substr(0, length));
  EXPECT_GT(refused, offered * 9 / 10);  // only the tail is optional (rms_px)
  constexpr char kBits[] = {'\x01', '\x20', '\x80'};
  for (std::size_t place = 0; place < whole.size(); place += 7) {
    std::string broken = whole;
    broken[place] = static_cast<char>(broken[place] ^ kBits[place % 3]);
    offer(broken);
  }
}

TEST_F(CalibrationFileTest, RefusesToWriteWhatCouldNotBeReadBack) {
  EXPECT_THROW(write_calibration(file_, std::vector<CameraModel>{}), InvalidInput);
  auto twice = odd_camera("cam00", 0.1);
  EXPECT_THROW(write_calibration(file_, std::vector<CameraModel>{twice, twice}), InvalidInput);
  twice.t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_calibration(file_, std::vector<CameraModel>{twice}), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_THROW(write_calibration("/nowhere/calibration.yaml", std::vector<CameraModel>{odd_camera("a", 0)}),
               std::system_error);
}

}  // namespace
}  // namespace rotunda::capture
