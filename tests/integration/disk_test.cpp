// The disk fails, is full or slow under a recording daemon (failing_disk.c, preloaded). Every test sees that its fault
// has struck; the control run is the same without one.
#include "tests/integration/environment.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::size_t kCameras = 3;

class Disk : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    studio_ = std::make_unique<TestStudio>(TestStudioOptions{.cameras = kCameras, .width = kWidth, .height = kHeight});
    rig_ = write_rig({.cameras = kCameras, .queue_frame_sets = 4});
  }

  // The address sanitizer's library must come first.
  std::unique_ptr<ScopedProgram> daemon_with(const std::string& fault, const std::string& value) {
    const Environment environment({{"LD_PRELOAD", std::string(ROTUNDA_ASAN_LIBRARY) + " " + ROTUNDA_FAILING_DISK},
                                   {fault, value},
                                   {"FAILING_DISK_TOLD", told().string()}});
    return start_daemon(rig_);
  }

  fs::path told() const { return folder() / "struck"; }
  std::size_t struck() const { return fs::exists(told()) ? fs::file_size(told()) : 0; }

  std::unique_ptr<TestStudio> studio_;
  fs::path rig_;
};

TEST_F(Disk, WithoutAFaultEverythingIsWhole) {
  const auto daemon = daemon_with("FAILING_DISK_WRITE_AFTER", "0");
  EXPECT_EQ(rotunda({"take", "start", "control", "--frames", "8"}).exit_code, 0);
  EXPECT_EQ(verify("control", 0)["complete"], 8);
  EXPECT_EQ(struck(), 0u);
}

TEST_F(Disk, IsBroughtUpToDateEverySecondWhileATakeIsRecorded) {
  const auto daemon = daemon_with("FAILING_DISK_TELLS_SYNCS", "1");
  constexpr std::size_t kSeconds = 10;
  EXPECT_EQ(struck(), 0u) << "nothing is recorded yet";
  const auto frames = std::to_string(kSeconds * static_cast<std::size_t>(kRate));
  EXPECT_EQ(rotunda({"take", "start", "synced", "--frames", frames}).exit_code, 0);
  EXPECT_GE(struck(), kCameras * kSeconds / 2) << "half as often at the least, on a machine that is busy elsewhere";
}

TEST_F(Disk, AWriteErrorEndsTheTakeLoudAndWhatWasWrittenIsValid) {
  const auto daemon = daemon_with("FAILING_DISK_WRITE_AFTER", "100");
  const auto taken = rotunda({"take", "start", "broken", "--frames", "40"});
  EXPECT_EQ(taken.exit_code, 4) << taken.out;
  EXPECT_THAT(taken.err, testing::AllOf(HasSubstr("ended early"), HasSubstr(".mkv"), HasSubstr("Input/output error")));
  EXPECT_GT(struck(), 0u);
  const auto report = rotunda({"take", "recover", "broken", "--json"});
  const auto recovered = nlohmann::json::parse(report.out);
  EXPECT_GE(recovered["complete"], 3) << recovered.dump(2);
  for (const auto& camera : recovered["cameras"]) EXPECT_EQ(camera["corrupt"], 0);
  EXPECT_TRUE(daemon->running());
}

TEST_F(Disk, FullItClosesTheTakeValid) {
  const auto daemon = daemon_with("FAILING_DISK_FULL_AFTER", "100");
  const auto taken = rotunda({"take", "start", "full", "--frames", "40"});
  EXPECT_EQ(taken.exit_code, 4) << taken.out;
  EXPECT_THAT(taken.err, HasSubstr("No space left on device"));
  EXPECT_GT(struck(), 0u);
  const auto recovered = nlohmann::json::parse(rotunda({"take", "recover", "full", "--json"}).out);
  EXPECT_GE(recovered["complete"], 3) << recovered.dump(2);
  for (const auto& camera : recovered["cameras"]) EXPECT_EQ(camera["corrupt"], 0) << "half a frame is none";
}

TEST_F(Disk, ASyncErrorIsNotPretendedAway) {
  const auto daemon = daemon_with("FAILING_DISK_SYNC_AFTER", "1");
  const auto taken = rotunda({"take", "start", "unsafe", "--frames", "60"});
  EXPECT_EQ(taken.exit_code, 4) << taken.out;
  EXPECT_THAT(taken.err, HasSubstr("cannot be brought to disk"));
  EXPECT_GT(struck(), 0u);
  EXPECT_THAT(rotunda({"take", "list"}).out, HasSubstr("interrupted")) << "nobody says that it is complete";
}

TEST_F(Disk, TooSlowItCostsFrameSetsThatAreCountedAndNamed) {
  const auto daemon = daemon_with("FAILING_DISK_DELAY_US", "200000");  // 0.6 s a frame set, which come at 4 Hz
  const auto taken = rotunda({"take", "start", "slow", "--frames", "30"});
  EXPECT_EQ(taken.exit_code, 1) << taken.out << taken.err;
  EXPECT_GT(struck(), 0u);
  const auto shown = nlohmann::json::parse(rotunda({"take", "show", "slow", "--json"}).out);
  EXPECT_EQ(shown["frame_sets"], 30) << "every trigger is accounted for";
  for (const auto& camera : shown["cameras"]) {
    EXPECT_GT(camera["missing_because"]["disk too slow"], 0) << camera.dump(2);
    EXPECT_GT(camera["frames"], 4);
  }
  EXPECT_EQ(rotunda({"take", "verify", "slow"}).exit_code, 1);
  EXPECT_GT(status()["cameras"][0]["missing"]["disk too slow"], 0);
}

}  // namespace
}  // namespace rotunda::tests
