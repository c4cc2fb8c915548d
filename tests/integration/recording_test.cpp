// The daemon records cameras that are there, partly there, or go away while it does.
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "capture/take/take_reader.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TestStudioOptions cameras_here(std::size_t count) {
  return {.cameras = count, .width = kWidth, .height = kHeight};
}

class Recording : public StudioTest {};

TEST_F(Recording, OfAllCamerasIsCompleteAndExactlyOnTheTriggerGrid) {
  const auto rig = write_rig();
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig);
  EXPECT_EQ(camera_states(status()), "streaming streaming streaming");
  const auto taken = rotunda({"take", "start", "five", "--frames", "5"});
  EXPECT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  const auto report = verify("five", 0);
  EXPECT_EQ(report["complete"], 5) << report.dump(2);
  EXPECT_EQ(report["whole"], true);

  const capture::TakeReader take(takes() / "five");
  ASSERT_EQ(take.frame_set_count(), 5u);
  const auto start = take.read(0).time;
  const auto period = std::chrono::nanoseconds(std::llround(1e9 / kRate));
  for (std::size_t i = 0; i < 5; ++i) {
    const auto set = take.read(i);
    for (const auto& slot : set.slots) {
      ASSERT_TRUE(slot.frame) << to_string(*slot.missing_because);
      EXPECT_EQ(slot.frame->exposure_start, start + static_cast<int>(i) * period);
    }
  }
}

TEST_F(Recording, CanBeListedShownAndExported) {
  const TestStudio studio(cameras_here(2));
  const auto daemon = start_daemon(write_rig({.cameras = 2}));
  ASSERT_EQ(rotunda({"take", "start", "two", "--frames", "2", "--note", "a try"}).exit_code, 0);
  EXPECT_THAT(rotunda({"take", "list"}).out, AllOf(HasSubstr("two"), HasSubstr("complete"), HasSubstr("a try")));
  EXPECT_THAT(rotunda({"take", "show", "two"}).out, AllOf(HasSubstr("cam01"), HasSubstr("160 x 128")));
  const auto before = contents_of(takes() / "two");
  const auto exported = rotunda({"take", "export", "two", "--images", (folder() / "shots").string()});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_EQ(contents_of(folder() / "shots").size(), 2u + 2u * 2u);  // two folders of two pictures
  EXPECT_EQ(contents_of(takes() / "two"), before);
}

TEST_F(Recording, StartsOnlyWhenACameraAnswers) {
  const auto daemon = start_daemon(write_rig());
  const auto idle = status();
  EXPECT_EQ(idle["state"], "idle");
  for (const auto& camera : idle["cameras"])
    EXPECT_THAT(camera["problem"], HasSubstr(camera["name"].get<std::string>()));
  const auto refused = rotunda({"take", "start", "nobody", "--frames", "1"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("no camera streams"), HasSubstr("cam00"), HasSubstr("cam01"), HasSubstr("cam02")));
  EXPECT_TRUE(contents_of(takes()).empty());
  EXPECT_TRUE(daemon->running());
}

TEST_F(Recording, GoesOnWithoutAMissingCameraAndSaysWhich) {
  const TestStudio studio(cameras_here(2));
  const auto daemon = start_daemon(write_rig());
  const auto degraded = status();
  EXPECT_EQ(degraded["state"], "armed");
  EXPECT_EQ(camera_states(degraded), "streaming streaming lost");
  EXPECT_THAT(daemon->err(), AllOf(HasSubstr("cam02"), HasSubstr("2 of 3 cameras")));
  const auto taken = rotunda({"take", "start", "partly", "--frames", "2"});
  EXPECT_EQ(taken.exit_code, 1) << taken.err;
  EXPECT_THAT(taken.err, HasSubstr("without cam02"));
  const auto report = verify("partly", 1);
  EXPECT_EQ(report["incomplete"], 2);
  EXPECT_EQ(report["cameras"][1]["missing"], 0) << report.dump(2);
  EXPECT_EQ(report["cameras"][2]["missing"], 2);
}

TEST_F(Recording, EndsCleanlyWithCtrlC) {
  const TestStudio studio(cameras_here(2));
  const auto daemon = start_daemon(write_rig({.cameras = 2}));
  const auto taking = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start",
                                        "long", "--duration", "600s"});
  wait_for_status([](const auto& now) { return now["take"]["complete"] >= 2; });
  taking->send(SIGINT);
  EXPECT_EQ(taking->wait(), 0) << taking->err();
  const auto report = verify("long", 0);
  EXPECT_EQ(report["state"], "complete");
  EXPECT_GE(report["complete"], 2);
}

TEST_F(Recording, SurvivesTheDaemonsDeath) {
  const TestStudio studio(cameras_here(2));
  const auto rig = write_rig({.cameras = 2});
  auto daemon = start_daemon(rig);
  ASSERT_EQ(rotunda({"take", "start", "cut"}).exit_code, 0);
  const auto last = wait_for_status([](const auto& now) { return now["take"]["complete"] >= 3; });
  daemon->send(SIGKILL);
  EXPECT_EQ(daemon->wait(), 128 + SIGKILL);

  const auto cut = verify("cut", 1);
  EXPECT_EQ(cut["state"], "recording");
  EXPECT_GE(cut["complete"], last["take"]["complete"]);
  EXPECT_LE(cut["incomplete"], 1);  // the one that was being written
  EXPECT_THAT(rotunda({"take", "verify", "cut"}).out, HasSubstr("rotunda take recover cut"));
  EXPECT_LE(rotunda({"take", "recover", "cut"}).exit_code, 1);
  const auto recovered = rotunda({"take", "verify", "cut", "--json"});
  EXPECT_EQ(nlohmann::json::parse(recovered.out)["state"], "recovered");
  EXPECT_EQ(nlohmann::json::parse(recovered.out)["complete"], cut["complete"]);

  daemon = start_daemon(rig);
  wait_for_status([](const auto& now) { return camera_states(now) == "streaming streaming"; });
  const auto before = contents_of(takes() / "cut");
  const auto again = rotunda({"take", "start", "cut", "--frames", "1"});
  EXPECT_EQ(again.exit_code, 3);
  EXPECT_THAT(again.err, HasSubstr((takes() / "cut").string()));
  EXPECT_EQ(contents_of(takes() / "cut"), before);
  EXPECT_EQ(rotunda({"take", "start", "next", "--frames", "2"}).exit_code, 0);
  EXPECT_EQ(verify("next", 0)["complete"], 2);
}

TEST_F(Recording, TellsOfACameraThatWentAwayAndTakesItBack) {
  auto studio = std::make_unique<TestStudio>(cameras_here(2));
  const auto daemon = start_daemon(write_rig({.cameras = 2}));
  ASSERT_EQ(rotunda({"take", "start", "left"}).exit_code, 0);
  studio.reset();
  // First the daemon misses their pictures, then their answers; the take's end in between brings none of them back.
  wait_for_status([](const auto& now) { return camera_states(now) == "lost lost"; });
  EXPECT_THAT(rotunda({"take", "stop"}).exit_code, testing::AnyOf(1, 4));  // 4: it has ended by itself meanwhile
  EXPECT_EQ(camera_states(status()), "lost lost");
  const auto is_told = [](const auto& camera) {
    return camera["problem"].template get<std::string>().starts_with(camera["name"].template get<std::string>());
  };
  wait_for_status([&](const auto& now) { return std::ranges::all_of(now["cameras"], is_told); });
  EXPECT_EQ(camera_states(status()), "lost lost");
  const auto report = verify("left", 1);
  EXPECT_EQ(report["state"], "complete");
  EXPECT_GE(report["cameras"][0]["frames"], 1);
  EXPECT_GE(report["cameras"][0]["missing"], 1);

  studio = std::make_unique<TestStudio>(cameras_here(2));
  wait_for_status([](const auto& now) { return camera_states(now) == "streaming streaming"; });
  const auto back = rotunda({"take", "start", "back", "--frames", "2"});
  ASSERT_EQ(back.exit_code, 0) << back.err;
  EXPECT_EQ(verify("back", 0)["complete"], 2);
}

}  // namespace
}  // namespace rotunda::tests
