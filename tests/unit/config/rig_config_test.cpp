#include "config/rig_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "config/errors.h"

namespace rotunda::config {
namespace {

using ::testing::HasSubstr;

std::filesystem::path written(const std::string& text) {
  const auto file = std::filesystem::path(::testing::TempDir()) /
                    (std::string("rig_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml");
  std::ofstream(file) << text;
  return file;
}

std::string mistakes_in(const std::string& text) {
  try {
    load_rig(written(text));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

constexpr auto kOneCamera = "cameras: [{name: cam00, address: 127.0.0.1}]\n";

TEST(LoadRig, ReadsTheShippedSimulatedStudio) {
  const auto rig = load_rig(ROTUNDA_SOURCE_DIR "/config/simulated-studio.yaml");
  ASSERT_EQ(rig.cameras.size(), 10U);
  EXPECT_EQ(rig.cameras[9].name, "cam09");
  EXPECT_EQ(rig.cameras[9].device, "127.0.0.10");
  EXPECT_EQ(rig.cameras[9].width, 720);
  EXPECT_EQ(rig.trigger.rate_hz, 25.0);
  EXPECT_EQ(rig.calibration->filename(), "simulated-studio.calibration.yaml");
  EXPECT_TRUE(rig.storage.takes.is_absolute());
}

TEST(LoadRig, TellsEveryMistakeAtOnceWithItsPlace) {
  const auto text = mistakes_in(
      "cameras:\n"
      "  - { name: cam00, address: 127.0.0.1, exposure_us: fast }\n"
      "  - { name: cam00, adress: 127.0.0.2 }\n"
      "trigger: { mode: sometimes, rate_hz: -3 }\n"
      "volume: { min: [0, 0], max: [1, 1, 1] }\n");
  EXPECT_THAT(text,
              HasSubstr(".yaml:2:53: cameras[0].exposure_us: expected 1 to 10000000 microseconds, found \"fast\""));
  EXPECT_THAT(text, HasSubstr("cameras[1].adress: unknown key; did you mean \"address\"?"));
  EXPECT_THAT(text, HasSubstr("cameras[1].name: \"cam00\" is cameras[0] already"));
  EXPECT_THAT(text,
              HasSubstr(":4:18: trigger.mode: expected one of action, freerun, line, software, found \"sometimes\""));
  EXPECT_THAT(text, HasSubstr("trigger.rate_hz: expected a rate of 0.1 to 1000 Hz"));
  EXPECT_THAT(text, HasSubstr("volume.min: expected [x, y, z] in metres, found a list"));
}

TEST(LoadRig, CamerasOfOneTakeAreTheSameFolder) {
  const std::string take = "trigger: { mode: freerun }\ncamera_defaults: { source: replay }\ncameras:\n";
  const auto rig =
      load_rig(written(take + "  - { name: a, address: takes/walk }\n  - { name: b, address: takes/walk }\n"));
  ASSERT_EQ(rig.cameras.size(), 2U);
  EXPECT_EQ(rig.cameras[0].device, rig.cameras[1].device);
  EXPECT_THAT(mistakes_in("cameras:\n  - { name: a, address: 127.0.0.1 }\n  - { name: b, address: 127.0.0.1 }\n"),
              HasSubstr("cameras[1].address: \"127.0.0.1\" is cameras[0] already"));
}

TEST(LoadRig, ReadsV4l2CamerasWithTheirControlsInOrder) {
  const auto rig = load_rig(written(
      "camera_defaults: { source: v4l2, pixel_format: YUYV, controls: { gain: 3, auto_exposure: Manual Mode } }\n"
      "cameras:\n"
      "  - { name: a, address: /dev/video0 }\n"
      "  - { name: b, serial: '77', controls: { white_balance_automatic: false, gain: 9 } }\n"
      "  - { name: c, source: aravis, address: 10.0.0.3, gain_db: 2 }\n"));
  using Controls = std::vector<std::pair<std::string, std::string>>;
  EXPECT_EQ(rig.cameras[0].source, "v4l2");
  EXPECT_EQ(rig.cameras[0].device, "/dev/video0");
  EXPECT_EQ(rig.cameras[0].controls, (Controls{{"gain", "3"}, {"auto_exposure", "Manual Mode"}}));
  EXPECT_EQ(rig.cameras[1].controls,
            (Controls{{"gain", "9"}, {"auto_exposure", "Manual Mode"}, {"white_balance_automatic", "false"}}));
  EXPECT_EQ(rig.cameras[2].source, "aravis");
}

TEST(LoadRig, SaysWhatACameraOfItsKindCannotHave) {
  const auto text = mistakes_in(
      "cameras:\n"
      "  - { name: a, source: v4l2, mac: '02:00:00:00:00:01', gain_db: 3 }\n"
      "  - { name: b, address: 10.0.0.2, controls: { gain: 3 } }\n"
      "  - { name: c, source: v4l2, address: /dev/video1, controls: { gain: [1, 2] } }\n");
  EXPECT_THAT(text, HasSubstr("cameras[0].mac: expected address (/dev/video0, /dev/v4l/by-path/...) or serial"));
  EXPECT_THAT(text, HasSubstr("cameras[0].gain_db: expected no decibels for a v4l2 camera"));
  EXPECT_THAT(text, HasSubstr("cameras[1].controls: expected controls only where source is v4l2"));
  EXPECT_THAT(text, HasSubstr("cameras[2].controls: expected control names"));
}

TEST(LoadRig, TellsMistakesInTheOrderOfTheFile) {
  const auto text = mistakes_in("triger: {}\ncameras: [{name: a, address: x, wide: 3}]\nname: [1]\n");
  const auto first = text.find(":1:1: triger"), second = text.find(":2:"), third = text.find(":3:");
  ASSERT_NE(third, std::string::npos) << text;
  EXPECT_LT(first, second) << text;
  EXPECT_LT(second, third) << text;
}

TEST(LoadRig, RefusesANameThatWouldLeaveTheTakesFolder) {
  EXPECT_THAT(mistakes_in("cameras: [{name: ../etc, address: 127.0.0.1}]"),
              HasSubstr("cameras[0].name: expected a name"));
}

TEST(LoadRig, ReadsHowCamerasFollowThePtpMaster) {
  const auto rig = load_rig(written(std::string(kOneCamera) + "trigger: {ptp: false, ptp_offset_limit_us: 5}\n"));
  EXPECT_FALSE(rig.trigger.ptp);
  EXPECT_EQ(rig.trigger.ptp_offset_limit_us, 5.0);
  EXPECT_THAT(mistakes_in(std::string(kOneCamera) + "trigger: {ptp: often, ptp_wait_s: -1}\n"),
              testing::AllOf(HasSubstr(":2:16: trigger.ptp: expected true or false"), HasSubstr("trigger.ptp_wait_s")));
}

TEST(LoadRig, ReadsHowTheSimulatedCamerasErrAndFindsTheirFaultsBesideIt) {
  const auto file = written(std::string(kOneCamera) + "simulator: {clocks: realistic, faults: faults.yaml}\n");
  const auto rig = load_rig(file);
  EXPECT_EQ(rig.simulator.clocks, "realistic");
  EXPECT_EQ(rig.simulator.faults,
            std::filesystem::weakly_canonical(std::filesystem::absolute(file).parent_path() / "faults.yaml"));
  EXPECT_THAT(mistakes_in(std::string(kOneCamera) + "simulator: {clocks: late}\n"),
              HasSubstr(":2:21: simulator.clocks: expected one of ideal, realistic"));
}

TEST(LoadRig, ReadsCameraSettingsByPlainNameAndFeaturesByTheirOwn) {
  const auto rig = load_rig(
      written("camera_defaults: { user_set: UserSet1, features: { Gamma: 0.45, LineInverter: true } }\n"
              "cameras:\n"
              "  - { name: a, address: 1.2.3.4, offset_x: 16, white_balance: auto_once, features: { Gamma: 1 } }\n"
              "  - { name: b, address: 1.2.3.5, white_balance: { red: 1.5, blue: 2 } }\n"));
  const auto& [a, b] = std::tie(rig.cameras[0], rig.cameras[1]);
  EXPECT_EQ(a.user_set, "UserSet1");
  EXPECT_EQ(a.offset_x, 16);
  EXPECT_FALSE(a.offset_y);
  EXPECT_TRUE(a.white_balance->auto_once);
  EXPECT_THAT(a.features,
              ::testing::ElementsAre(::testing::Pair("Gamma", "1"), ::testing::Pair("LineInverter", "true")));
  EXPECT_EQ(b.white_balance->blue, 2.0);
  EXPECT_EQ(b.features[0].second, "0.45");
}

TEST(LoadRig, TellsMistakesInCameraSettingsWithTheirPlace) {
  const auto text = mistakes_in(
      "cameras:\n"
      "  - name: a\n"
      "    address: 1.2.3.4\n"
      "    white_balance: { red: 100, bleu: 1 }\n"
      "    features: [Gamma]\n"
      "    offset_x: -2\n");
  EXPECT_THAT(text, HasSubstr(":4:27: cameras[0].white_balance.red: expected a ratio of 0.05 to 20, found \"100\""));
  EXPECT_THAT(text, HasSubstr("cameras[0].white_balance.blue: is missing"));
  EXPECT_THAT(text, HasSubstr("cameras[0].white_balance.bleu: unknown key; did you mean \"blue\"?"));
  EXPECT_THAT(text, HasSubstr(":5:15: cameras[0].features: expected GenICam feature names"));
  EXPECT_THAT(text, HasSubstr(":6:15: cameras[0].offset_x: expected 0 to 16384 pixels"));
}

TEST(LoadRig, RefusesACameraFoundTwoWaysOrNone) {
  EXPECT_THAT(mistakes_in("cameras: [{name: a, address: 1.2.3.4, serial: X}]"), HasSubstr("only one of address"));
  EXPECT_THAT(mistakes_in("cameras: [{name: a}]"), HasSubstr("how to find the camera"));
}

TEST(LoadRig, RefusesWhatIsNoMapping) {
  EXPECT_THAT(mistakes_in("just words"), HasSubstr("expected keys and values"));
  EXPECT_THAT(mistakes_in(""), HasSubstr("cameras: is missing"));
  EXPECT_THAT(mistakes_in("cameras: [3]"), HasSubstr("cameras[0]: expected keys and values, found \"3\""));
}

TEST(LoadRig, SaysWhereTheYamlBreaks) {
  EXPECT_THAT(mistakes_in("cameras: [\n  {name: a"), HasSubstr("is not YAML"));
}

TEST(LoadRig, NamesAFileThatIsNotThere) {
  try {
    load_rig("/nowhere/rig.yaml");
    FAIL() << "read a file that is not there";
  } catch (const std::system_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/rig.yaml"));
  }
}

TEST(LoadRig, SurvivesEveryTruncationOfAGoodFile) {
  std::ifstream stream(ROTUNDA_SOURCE_DIR "/config/simulated-studio.yaml");
  const std::string whole((std::istreambuf_iterator<char>(stream)), {});
  for (std::size_t length = 0; length < whole.size(); length += 7) mistakes_in(whole.substr(0, length));
  EXPECT_EQ(mistakes_in(whole), "");
}

TEST(RigFileText, IsAcceptedByTheLoader) {
  auto rig = load_rig(written(kOneCamera));
  rig.cameras.push_back({.name = "cam01", .find_by = "serial", .device = "SR-1"});
  rig.cameras.push_back(
      {.name = "usb", .source = "v4l2", .find_by = "address", .device = "/dev/video2", .pixel_format = "MJPEG"});
  const auto again = load_rig(written(rig_file_text(rig)));
  ASSERT_EQ(again.cameras.size(), 3U);
  EXPECT_EQ(again.cameras[2].source, "v4l2");
  EXPECT_EQ(again.cameras[2].device, "/dev/video2");
  EXPECT_EQ(again.cameras[2].pixel_format, "MJPEG");
  EXPECT_EQ(again.cameras[1].pixel_format, "BayerRG8");
  EXPECT_EQ(again.cameras[1].find_by, "serial");
  EXPECT_EQ(again.trigger.rate_hz, rig.trigger.rate_hz);
}

TEST(RigFileText, KeepsWhatWouldBeYamlAndSaysWhatEachKeyDoes) {
  auto rig = load_rig(written(kOneCamera));
  rig.name = "studio: \"north\" #1";
  rig.cameras[0] = {.name = "left", .find_by = "serial", .device = "0x12: {a}"};
  rig.cameras.push_back({.name = "cam01", .find_by = "serial", .device = "22334455"});
  rig.storage.reserve_mb = 100.5;
  const std::vector<std::string> remarks{"Vendor Model, 10.0.0.2"};
  const auto text = rig_file_text(rig, remarks);
  const auto again = load_rig(written(text));
  EXPECT_EQ(again.name, rig.name);
  EXPECT_EQ(again.cameras[0].device, "0x12: {a}");
  EXPECT_EQ(again.cameras[1].device, "22334455");
  EXPECT_EQ(again.storage.reserve_mb, 100.5);
  EXPECT_FALSE(again.cameras[0].exposure_us) << "what nobody set stays a comment";
  for (const auto* words : {"# Vendor Model, 10.0.0.2", "# exposure_us: 5000", "# Microseconds", "# calibration:"})
    EXPECT_THAT(text, HasSubstr(words));
  std::istringstream lines(text);
  bool explained = false;
  for (std::string line; std::getline(lines, line);) {
    const bool key = line.find(':') != std::string::npos && line.find('#') == std::string::npos && line.back() != ':';
    if (line.rfind("  - ", 0) == 0 || line.find("name:") == 0 || line.find("  min") == 0 || line.find("  max") == 0)
      continue;
    if (key) {
      EXPECT_TRUE(explained) << line;
    }
    explained = line.find('#') != std::string::npos;
  }
}

}  // namespace
}  // namespace rotunda::config
