// Somebody sets this machine's clock while a take is recorded (stepping_clock.c, preloaded into the daemon).
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "capture/take/take_reader.h"
#include "tests/integration/environment.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFrameSets = 16;

class HostClockStep : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    studio_.emplace(TestStudioOptions{.cameras = 2, .width = kWidth, .height = kHeight});
    const auto rig = write_rig({.cameras = 2});
    const Environment environment({{"LD_PRELOAD", std::string(ROTUNDA_ASAN_LIBRARY) + " " + ROTUNDA_STEPPING_CLOCK},
                                   {"STEPPING_CLOCK", (folder() / "ahead").string()}});
    daemon_ = start_daemon(rig);
    wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming"; });
  }
  void set_clock(double seconds_ahead) const {
    const auto partial = folder() / "ahead.new";
    std::ofstream(partial) << seconds_ahead;
    std::filesystem::rename(partial, folder() / "ahead");
  }
  // Records; at the third frame set somebody does `meanwhile`.
  std::vector<std::string> record(const std::string& name, const std::function<void()>& meanwhile) {
    const auto take = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start",
                                        name, "--frames", std::to_string(kFrameSets)});
    wait_for_status([&](const json& now) { return now["take"]["name"] == name && now["take"]["frame_sets"] >= 3; });
    meanwhile();
    EXPECT_EQ(take->wait(), 0) << take->out() << take->err();
    EXPECT_EQ(verify(name, 0)["complete"], kFrameSets);
    expect_even_times(name);
    std::vector<std::string> incidents;
    for (const auto& incident : capture::read_take_journal(takes() / name).incidents)
      incidents.push_back(incident.text);
    return incidents;
  }
  void expect_even_times(const std::string& name) const {
    const capture::TakeReader take(takes() / name);
    const auto period = std::chrono::nanoseconds(std::llround(1e9 / kRate));
    for (std::size_t set = 0; set < take.frame_set_count(); ++set)
      for (const auto& slot : take.read(set).slots) {
        ASSERT_TRUE(slot.frame);
        EXPECT_EQ(slot.frame->exposure_start, take.time_of(0) + static_cast<int>(set) * period) << "frame set " << set;
      }
  }

  std::optional<TestStudio> studio_;
  std::unique_ptr<ScopedProgram> daemon_;
};

TEST_F(HostClockStep, IsToldInTheTakeWhoseTimesGoOnEvenly) {
  EXPECT_THAT(record("control", [] {}), IsEmpty());
  EXPECT_THAT(record("forward", [&] { set_clock(37.5); }),
              ElementsAre(HasSubstr("this machine's clock was set forward by 37.500 s")));
  EXPECT_THAT(daemon_->err(), HasSubstr("set forward by 37.500 s"));
}

TEST_F(HostClockStep, BackwardsByAnHourCostsNothingEither) {
  EXPECT_THAT(record("back", [&] { set_clock(-3600.0); }),
              ElementsAre(HasSubstr("this machine's clock was set back by 3600.000 s")));
}

}  // namespace
}  // namespace rotunda::tests
