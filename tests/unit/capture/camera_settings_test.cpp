#include "capture/source/camera_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/device_error.h"
#include "tests/unit/capture/fake_features.h"

namespace rotunda::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::device_error_of;

TEST(CameraSettings, ADifferenceIsWhatRoundingDoesNotExplain) {
  EXPECT_TRUE(is_same_setting("5000", "5000.5"));
  EXPECT_FALSE(is_same_setting("5000", "5010"));
  EXPECT_TRUE(is_same_setting("true", "1"));
  EXPECT_FALSE(is_same_setting("true", "false"));
  EXPECT_TRUE(is_same_setting("0x10", "16"));
  EXPECT_TRUE(is_same_setting("Off", "Off"));
  EXPECT_FALSE(is_same_setting("Off", "Once"));
  EXPECT_FALSE(is_same_setting("0", "1"));
}

TEST(CameraSettings, FeaturesAreWrittenInOrderAndWhatTheCameraMadeOfThemIsTold) {
  FakeFeatures camera;
  camera.values = {{"Gamma", "1"}, {"BlackLevel", "0"}, {"LineInverter", "false"}};
  camera.takes["BlackLevel"] = [](const std::string&) { return "15"; };
  const auto told = set_features(camera, "cam03", {{"LineInverter", "true"}, {"BlackLevel", "20"}, {"Gamma", "0.45"}});
  EXPECT_THAT(camera.calls, ElementsAre("LineInverter=true", "BlackLevel=20", "Gamma=0.45"));
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(to_string(told[0]), "BlackLevel: asked 20, the camera has 15");
  EXPECT_THAT(device_error_of([&] {
                set_features(camera, "cam03", {{"Gama", "1"}});
              }),
              AllOf(HasSubstr("cam03"), HasSubstr("Gama")));
}

TEST(CameraSettings, AUserSetIsChosenAndLoaded) {
  FakeFeatures camera;
  camera.values = {{"UserSetSelector", "Default"}};
  camera.commands["UserSetLoad"] = [] {};
  load_user_set(camera, "cam00", "UserSet1");
  EXPECT_THAT(camera.calls, ElementsAre("UserSetSelector=UserSet1", "UserSetLoad"));
  FakeFeatures without;
  EXPECT_THAT(device_error_of([&] { load_user_set(without, "cam00", "UserSet1"); }),
              AllOf(HasSubstr("cam00"), HasSubstr("UserSetSelector"), HasSubstr("user_set")));
}

TEST(CameraSettings, WhiteBalanceIsOneRatioAColourOrTheCamerasOwnOnce) {
  FakeFeatures camera;
  camera.values = {{"BalanceWhiteAuto", "Continuous"}, {"BalanceRatioSelector", "Green"}, {"BalanceRatio", "1"}};
  camera.takes["BalanceRatio"] = [](const std::string& asked) { return asked == "9" ? "8" : asked; };
  const auto told = set_white_balance(camera, "cam00", {.auto_once = false, .red = 1.25, .blue = 9});
  EXPECT_THAT(camera.calls, ElementsAre("BalanceWhiteAuto=Off", "BalanceRatioSelector=Red", "BalanceRatio=1.25",
                                        "BalanceRatioSelector=Blue", "BalanceRatio=9"));
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(to_string(told[0]), "BalanceRatio[Blue]: asked 9, the camera has 8");
  camera.calls.clear();
  EXPECT_THAT(set_white_balance(camera, "cam00", {.auto_once = true}), IsEmpty());
  EXPECT_THAT(camera.calls, ElementsAre("BalanceWhiteAuto=Once"));
  camera.values.erase("BalanceWhiteAuto");
  EXPECT_THAT(device_error_of([&] { set_white_balance(camera, "cam00", {.auto_once = true}); }),
              AllOf(HasSubstr("BalanceWhiteAuto"), HasSubstr("red")));
}

}  // namespace
}  // namespace rotunda::capture
