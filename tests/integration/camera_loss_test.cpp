// Cameras that die while a take is recorded, and a camera that none of us wrote.
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "capture/take/take_reader.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using capture::HoleReason;
using nlohmann::json;
using testing::HasSubstr;

constexpr double kLossRate = 10.0;

class CameraLoss : public StudioTest {
 protected:
  void serve() {
    studio_.emplace(TestStudioOptions{.cameras = 3, .width = kWidth, .height = kHeight});
    daemon_ = start_daemon(write_rig({.cameras = 3, .rate_hz = kLossRate}));
    wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming streaming"; });
    ASSERT_EQ(rotunda({"take", "start", "control", "--frames", "10"}).exit_code, 0) << "nothing is lost before";
  }
  // Returns once some of it is on disk.
  std::unique_ptr<ScopedProgram> start_take(const std::string& name, int frame_sets) {
    auto take = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start", name,
                                  "--frames", std::to_string(frame_sets)});
    wait_for_status([&](const json& now) { return now["take"]["name"] == name && now["take"]["frame_sets"] >= 10; });
    return take;
  }
  static std::vector<std::string> incidents_of(const capture::TakeReader& take) {
    std::vector<std::string> texts;
    for (const auto& incident : take.journal().incidents) texts.push_back(incident.text);
    return texts;
  }
  static std::string holes_of(const capture::TakeReader& take, const std::string& camera) {
    std::string holes;
    for (const auto& [trigger, cameras] : take.journal().missing)
      if (const auto hole = cameras.find(camera); hole != cameras.end())
        holes += fmt::format("trigger {} {}\n", trigger, to_string(hole->second));
    return holes;
  }

  std::optional<TestStudio> studio_;
  std::unique_ptr<ScopedProgram> daemon_;
};

TEST_F(CameraLoss, OneThatDiesIsToldCostsNoOtherAndRejoinsByItself) {
  serve();
  const auto take = start_take("loss", 250);
  (**studio_).set_faults(1, {.silent = true});
  const auto died = std::chrono::steady_clock::now();
  const auto told = wait_for_status([](const json& now) { return now["cameras"][1]["state"] == "lost"; });
  EXPECT_LT(std::chrono::steady_clock::now() - died, 5s) << "Aravis alone takes more than six";
  EXPECT_THAT(told["cameras"][1]["problem"].get<std::string>(), HasSubstr("cable"));
  EXPECT_EQ(told["state"], "recording");
  std::this_thread::sleep_for(3s);
  (**studio_).set_faults(1, {});
  wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming streaming"; });
  EXPECT_EQ(take->wait(), 1) << take->err();

  const auto report = verify("loss", 1);
  const capture::TakeReader reader(takes() / "loss");
  EXPECT_EQ(report["cameras"][0]["missing"], 0) << holes_of(reader, "cam00");
  EXPECT_EQ(report["cameras"][2]["missing"], 0) << holes_of(reader, "cam02");
  EXPECT_GE(report["cameras"][1]["missing"], 20) << "three seconds at least";
  EXPECT_GT(studio_->stats()[1].faults[simulator::FaultKind::silence], 0U);
  ASSERT_EQ(reader.frame_set_count(), 250U);
  EXPECT_TRUE(reader.read(249, 1).frame) << "it rejoined";
  std::map<HoleReason, int> reasons;
  for (const auto& [trigger, cameras] : reader.journal().missing)
    if (const auto hole = cameras.find("cam01"); hole != cameras.end()) ++reasons[hole->second];
  EXPECT_GE(reasons[HoleReason::camera_lost], 15);
  EXPECT_THAT(incidents_of(reader), testing::IsSupersetOf({"cam01 sends no pictures any more", "cam01 is back"}));
}

TEST_F(CameraLoss, WhenAllDieTheTakeIsClosedWithinThreeSecondsAndTheDaemonEndsQuickly) {
  serve();
  const auto take = start_take("dead", 6000);
  (**studio_).set_faults({.silent = true});
  const auto closed = wait_for_status([](const json& now) { return now["take"]["closed"] == true; });
  EXPECT_THAT(closed["take"]["failure"].get<std::string>(), HasSubstr("no camera sends pictures or answers"));
  EXPECT_NE(take->wait(), 0);

  const auto report = verify("dead", 1);
  EXPECT_EQ(report["state"], "complete");
  const capture::TakeReader reader(takes() / "dead");
  std::size_t last = 0;
  for (std::size_t set = 0; set < reader.frame_set_count(); ++set)
    for (std::size_t camera = 0; camera < 3; ++camera)
      if (reader.read(set, camera).frame) last = set;
  EXPECT_GE(last, 9U);
  EXPECT_LE(reader.frame_set_count() - last, static_cast<std::size_t>(3 * kLossRate)) << "three seconds of triggers";
  EXPECT_THAT(incidents_of(reader), testing::Contains("no camera is left"));

  const auto asked = std::chrono::steady_clock::now();
  daemon_->send(SIGTERM);
  EXPECT_EQ(daemon_->wait(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, 6s) << "one after the other three take seven and more";
}

// The slanting ramp it shows, all of it: a pixel is as the one a row below and a column to the left.
bool is_ramp(const capture::Image& image) {
  const auto pixels = image.bytes();
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = 1; i + width <= pixels.size(); ++i)
    if (i % width != 0 && pixels[i] != pixels[i + width - 1]) return false;
  return pixels.front() != pixels[width / 2];
}

// Of the package aravis-tools: another reading of the standard than ours, with a clock that nobody can ask. Beside one
// of ours, as a second kind of device.
TEST_F(StudioTest, AravisOwnFakeCameraIsRecordedBesideOursLikeAnyOther) {
  const std::string program = "/usr/bin/arv-fake-gv-camera-0.8";
  ASSERT_TRUE(fs::exists(program)) << program << " is not there: apt-get install aravis-tools";
  const ScopedProgram fake({program, "-i", "127.0.0.1", "-s", "GV07"}, folder() / "fake");
  const TestStudio ours({.cameras = 1, .width = kWidth, .height = kHeight, .first_address = 2});
  const auto rig = folder() / "fake.yaml";
  std::ofstream(rig) << "trigger: { mode: software, rate_hz: 4 }\n"
                        "storage: { reserve_mb: 1 }\n"
                        "cameras:\n"
                        "  - { name: cam00, address: 127.0.0.1, pixel_format: Mono8, width: 256, height: 128,\n"
                        "      exposure_us: 4000 }\n"
                        "  - { name: cam01, address: 127.0.0.2 }\n";
  const auto daemon = start_daemon(rig);
  const auto ready = wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming"; });
  EXPECT_EQ(ready["cameras"][0]["serial"], "GV07");
  EXPECT_EQ(ready["cameras"][0]["clock"], "none");
  const auto taken = rotunda({"take", "start", "fake", "--frames", "12"});
  const auto report = verify("fake", taken.exit_code);
  EXPECT_EQ(report["frame_sets"], 12) << taken.out << taken.err;
  EXPECT_GE(report["complete"], 9) << "it leaves out a frame now and then, and does not tell";
  EXPECT_EQ(report["cameras"][1]["missing"], 0);
  const capture::TakeReader take(takes() / "fake");
  for (std::size_t set = 0; set < take.frame_set_count(); ++set) {
    const auto slot = take.read(set, 0);
    EXPECT_TRUE(!slot.frame || is_ramp(slot.frame->image)) << "frame set " << set;
  }
}

}  // namespace
}  // namespace rotunda::tests
