// Surfaces while cameras run: made beside a recording that loses nothing for it, shown to whoever looks.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "capture/picture.h"
#include "tests/integration/house_test.h"

namespace rotunda::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class LiveSurfaces : public StudioTest {};

bool watched_by_one(const json& status) {
  return status["surfaces"]["made"] >= 2 && status["surfaces"]["viewers"] == 1;
}

double spread_of(const cv::Mat& rgb) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(rgb, mean, deviation);
  return deviation[0] + deviation[1] + deviation[2];
}

TEST_F(LiveSurfaces, AreMadeBesideARecordingThatLosesNothingAndAKilledViewerDoesNotMatter) {
  const auto rig = write_rig({.cameras = 4});
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig, {"--surfaces"});
  ASSERT_EQ(rotunda({"rig", "live"}).exit_code, 0);
  wait_for_status([](const json& now) { return now["surfaces"]["made"] >= 1; });  // sanitized, the first takes its time
  const auto viewer = start("rotunda", {"--daemon", socket().string(), "play", "--live", "--picture",
                                        (folder() / "never.png").string(), "--surfaces", "1000000"});
  wait_for_status(watched_by_one);
  const auto recording = start("rotunda", {"--daemon", socket().string(), "take", "start", "beside", "--frames", "16"});
  const auto during = wait_for_status([](const json& now) { return now["take"]["frame_sets"] >= 4; });
  viewer->send(SIGKILL);
  EXPECT_EQ(recording->wait(), 0) << recording->err();
  EXPECT_EQ(verify("beside", 0)["complete"], 16);
  EXPECT_TRUE(daemon->wait_for("take beside: can be looked at")) << "a live pass follows by itself";
  const auto review = rotunda({"--json", "play", "beside", "--picture", (folder() / "review.png").string()});
  EXPECT_EQ(review.exit_code, 0) << review.err;
  EXPECT_EQ(json::parse(review.out)["closed"], true);
  const auto after = wait_for_status([](const json& now) { return now["surfaces"]["viewers"] == 0; });
  EXPECT_GT(after["surfaces"]["made"], during["surfaces"]["made"]);

  // Right after a take the rig is not live again yet: these are made of sets that came later.
  const auto now = wait_for_status([&](const json& status) {
    return status["surfaces"]["made"] >= after["surfaces"]["made"].get<int>() + 3 &&
           status["surfaces"]["rate_hz"] > 0.0;
  });
  EXPECT_EQ(now["surfaces"]["state"], "running");
  EXPECT_GT(now["surfaces"]["delay_ms"], 0.0);
  EXPECT_THAT(rotunda({"status"}).out, HasSubstr("surfaces: "));
}

TEST_F(LiveSurfaces, AreDrawnForThePlayerAndWithFourCamerasForTheKiosk) {
  const auto rig = write_rig({.cameras = 5});
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig, {"--surfaces"});
  const auto early = rotunda({"play", "--live", "--picture", (folder() / "early.png").string()});
  EXPECT_EQ(early.exit_code, 4);
  EXPECT_THAT(early.err, HasSubstr("rotunda rig live")) << "nothing is triggered: it says what to do";
  ASSERT_EQ(rotunda({"rig", "live"}).exit_code, 0);

  const auto file = folder() / "live.png";
  const auto played = rotunda({"--json", "play", "--live", "--picture", file.string()});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const auto told = json::parse(played.out);
  EXPECT_EQ(told["closed"], true) << told.dump(2);
  EXPECT_GT(told["volume"], 0.02) << "a person's, cubic metres";
  EXPECT_LT(told["volume"], 0.4);
  EXPECT_GT(spread_of(capture::read_rgb(file)), 10.0) << "somebody is in the picture";

  const auto kiosk_file = folder() / "kiosk.png";
  const auto kiosk = run("rotunda-kiosk", {"--daemon", socket().string(), "--picture", kiosk_file.string(), "--size",
                                           "640x360", "--surfaces", "3", "--json"});
  ASSERT_EQ(kiosk.exit_code, 0) << kiosk.err;
  EXPECT_EQ(json::parse(kiosk.out)["pictures"], 4);
  EXPECT_EQ(capture::read_rgb(kiosk_file).size(), cv::Size(640, 360));

  unsetenv("DISPLAY");
  const auto headless = run("rotunda-kiosk", {"--daemon", socket().string(), "--display", "window"});
  EXPECT_EQ(headless.exit_code, 4);
  EXPECT_THAT(headless.err, HasSubstr("no display"));
}

// The skeleton of who is before the cameras, for as long as somebody watches.
TEST_F(LiveSurfaces, GiveWayToMotionCapture) {
  const auto rig = write_rig({.cameras = 6, .width = 320, .height = 256});
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig, {"--surfaces"});
  const auto early = rotunda({"mocap", "--live"});
  EXPECT_EQ(early.exit_code, 4);
  EXPECT_THAT(early.err, HasSubstr("rotunda rig live"));
  EXPECT_EQ(rotunda({"mocap", "some-take", "--live"}).exit_code, 3);
  ASSERT_EQ(rotunda({"rig", "live"}).exit_code, 0);

  const auto bvh = folder() / "live.bvh", joints_file = folder() / "live.json";
  const auto outcome =
      rotunda({"--json", "mocap", "--live", "--duration", "3", "-o", bvh.string(), "--joints", joints_file.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("frames of a person"));
  std::istringstream lines(outcome.out);
  json last;
  int frames = 0;
  for (std::string line; std::getline(lines, line);)
    if (const auto frame = json::parse(line); frame.contains("joints")) {
      last = frame;
      ++frames;
    }
  ASSERT_GE(frames, 2) << outcome.out;
  EXPECT_NEAR(last["height_m"].get<double>(), 1.78, 0.12) << "the simulated person's";
  const double pelvis = last["joints"]["pelvis"]["position"][2].get<double>();
  EXPECT_NEAR(pelvis, 0.98, 0.15);
  std::ifstream stream(joints_file);
  EXPECT_GE(json::parse(stream)["frames"].size(), 10U) << "at the rig's rate, whatever could be looked at";
  EXPECT_TRUE(std::filesystem::exists(bvh));
}

TEST_F(LiveSurfaces, SayWhyThereAreNone) {
  const auto rig = write_rig({.cameras = 2});
  std::filesystem::remove(folder() / "rig.calibration.yaml");
  const auto sim = start_sim(write_rig({.cameras = 2}, "sim"));
  const auto daemon = start_daemon(rig, {"--surfaces"});
  ASSERT_EQ(rotunda({"rig", "live"}).exit_code, 0);
  const auto status = wait_for_status([](const json& now) { return now["surfaces"]["problem"] != ""; });
  EXPECT_THAT(status["surfaces"]["problem"].get<std::string>(), HasSubstr("rotunda calibrate"));
}

}  // namespace
}  // namespace rotunda::tests
