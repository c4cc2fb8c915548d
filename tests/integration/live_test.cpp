// The rig live without a take: triggered and watched, nothing written.
#include "tests/integration/house_test.h"

namespace rotunda::tests {
namespace {

using testing::HasSubstr;

class Live : public StudioTest {};

bool all_watched(const nlohmann::json& status) {
  for (const auto& camera : status["cameras"])
    if (camera["focus"].is_null() || camera["rate_hz"] < 0.5 * kRate) return false;
  return status["state"] == "live";
}

TEST_F(Live, PicturesAreWatchedBeforeAndAfterATakeAndNothingIsWritten) {
  const auto rig = write_rig();
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig);
  const auto before = status();
  EXPECT_EQ(before["state"], "armed");
  EXPECT_TRUE(before["cameras"][0]["focus"].is_null()) << "no picture has come yet";

  const auto answer = rotunda({"rig", "live"});
  ASSERT_EQ(answer.exit_code, 0) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("live"));
  const auto live = wait_for_status(all_watched);
  for (const auto& camera : live["cameras"]) {
    EXPECT_GT(camera["focus"], 0.05) << camera.dump(2);
    EXPECT_LT(camera["clipped"], 0.2);
  }
  EXPECT_TRUE(contents_of(takes()).empty());

  const auto taken = rotunda({"take", "start", "between", "--frames", "4"});
  EXPECT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  EXPECT_EQ(verify("between", 0)["complete"], 4);
  wait_for_status([](const auto& now) { return now["state"] == "live"; });

  ASSERT_EQ(rotunda({"rig", "live", "--off"}).exit_code, 0);
  EXPECT_EQ(status()["state"], "armed");
}

TEST_F(Live, SaysWhyItIsNotAndGoesLiveWhenCamerasCome) {
  const auto rig = write_rig();
  const auto daemon = start_daemon(rig);
  EXPECT_THAT(rotunda({"rig", "live"}).out, HasSubstr("no camera streams"));
  const auto sim = start_sim(rig);
  wait_for_status(all_watched);
}

}  // namespace
}  // namespace rotunda::tests
