#include "capture/sync/clock_watch.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/capture/fake_features.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// A rig whose clock shows what the test says, and a camera that latches its own.
struct Bench {
  Timestamp now{1'700'000'000s};
  std::function<DeviceTime(Timestamp)> device_clock = [](Timestamp at) { return at.time_since_epoch(); };
  FakeFeatures camera;
  double hertz = 1e9;

  ClockWatch::Now rig_clock() {
    return [this] { return now += 20us; };  // a call takes that long
  }
  void with_latch(const std::string& command, const std::string& value) {
    camera.values[value] = "0";
    camera.commands[command] = [this, value] {
      now += 30us;
      const double ticks = static_cast<double>(device_clock(now).count()) * hertz * 1e-9;
      camera.values[value] = hertz == 1e9 ? fmt::format("{}", device_clock(now).count()) : fmt::format("{:.0f}", ticks);
      now += 30us;
    };
  }
  void with_ptp(const std::string& status) {
    camera.values = {{"PtpEnable", "false"}, {"PtpStatus", status}, {"PtpOffsetFromMaster", "0"}};
    camera.values["PtpClockID"] = "17";
    camera.values["PtpParentClockID"] = "4";
    camera.commands["PtpDataSetLatch"] = [] {};
    with_latch("TimestampLatch", "TimestampLatchValue");
  }
};

TEST(ClockWatch, APtpSlaveIsSwitchedOnAndItsTimeStampsAreTheRigs) {
  Bench bench;
  bench.with_ptp("Slave");
  bench.camera.values["PtpOffsetFromMaster"] = "-420";
  ClockWatch watch(bench.camera, {}, bench.rig_clock());
  watch.begin();
  EXPECT_THAT(bench.camera.calls, testing::Contains("PtpEnable=true"));
  const auto state = watch.look();
  EXPECT_EQ(state.kind, "ptp slave");
  EXPECT_TRUE(state.settled);
  EXPECT_EQ(state.offset, -420ns);
  EXPECT_EQ(state.error, 420ns);
  EXPECT_EQ(state.parent, "4");
  EXPECT_EQ(state.problem, "");
  EXPECT_EQ(watch.map().rig_time(1'700'000'123s + 7ns), Timestamp(1'700'000'123s) + 7ns);
}

TEST(ClockWatch, OlderCamerasHavePtpUnderAnotherName) {
  Bench bench;
  bench.camera.values = {
      {"GevIEEE1588", "true"}, {"GevIEEE1588Status", "SLAVE"}, {"GevIEEE1588OffsetFromMaster", "150000"}};
  bench.camera.commands["GevIEEE1588DataSetLatch"] = [] {};
  ClockWatch watch(bench.camera, {.ptp_offset_limit = 100us}, bench.rig_clock());
  watch.begin();
  EXPECT_THAT(bench.camera.calls, IsEmpty()) << "it was on already";
  const auto state = watch.look();
  EXPECT_EQ(state.kind, "ptp slave");
  EXPECT_THAT(state.problem, testing::AllOf(HasSubstr("150.0 us"), HasSubstr("100.0 us"), HasSubstr("ptp_offset")));
  EXPECT_FALSE(state.settled) << "it is waited for";
  bench.camera.values["GevIEEE1588OffsetFromMaster"] = "-90000";
  EXPECT_TRUE(watch.look().settled);
}

TEST(ClockWatch, UntilItIsSlaveAPtpCameraIsWaitedForAndModelled) {
  Bench bench;
  bench.with_ptp("Listening");
  bench.device_clock = [](Timestamp at) { return at - Timestamp(1'699'999'000s); };  // since it was switched on
  ClockWatch watch(bench.camera, {}, bench.rig_clock());
  watch.begin();
  auto state = watch.look();
  EXPECT_FALSE(state.settled);
  EXPECT_EQ(state.kind, "ptp listening");
  EXPECT_THAT(state.problem, HasSubstr("listening"));
  EXPECT_LT(std::chrono::abs(watch.map().rig_time(1000s) - Timestamp(1'700'000'000s)), 100us);
  bench.camera.values["PtpStatus"] = "Slave";
  bench.device_clock = [](Timestamp at) { return at.time_since_epoch(); };
  state = watch.look();
  EXPECT_TRUE(state.settled);
  EXPECT_EQ(state.problem, "");
  EXPECT_EQ(watch.map().rig_time(5s), Timestamp(5s));
}

TEST(ClockWatch, APtpClockOnUtcIsToldAndMovedByExactly37Seconds) {
  Bench bench;
  bench.with_ptp("Slave");
  bench.device_clock = [](Timestamp at) { return at.time_since_epoch() - 37s + 200us; };
  ClockWatch watch(bench.camera, {}, bench.rig_clock());
  watch.begin();
  const auto state = watch.look();
  EXPECT_EQ(state.moved, 37s);
  EXPECT_THAT(state.problem, testing::AllOf(HasSubstr("UTC"), HasSubstr("37 s behind")));
  EXPECT_EQ(watch.map().rig_time(1'700'000'000s), Timestamp(1'700'000'037s));

  bench.device_clock = [](Timestamp at) { return at.time_since_epoch() + 37s; };
  EXPECT_EQ(watch.look().moved, -37s) << "and of a machine that does not know its TAI offset";
}

TEST(ClockWatch, APtpMasterOnItsOwnTimeIsToldAndModelled) {
  Bench bench;
  bench.with_ptp("Slave");
  bench.device_clock = [](Timestamp at) { return at.time_since_epoch() - 5s; };
  ClockWatch watch(bench.camera, {}, bench.rig_clock());
  watch.begin();
  const auto state = watch.look();
  EXPECT_THAT(state.problem, testing::AllOf(HasSubstr("5.000 s behind"), HasSubstr("phc2sys")));
  EXPECT_LT(std::chrono::abs(watch.map().rig_time(1'700'000'000s) - Timestamp(1'700'000'005s)), 100us);
}

TEST(ClockWatch, ACameraWithoutPtpIsModelledFromItsLatchWhateverItsTicks) {
  for (const double hertz : {1e9, 125e6}) {
    Bench bench;
    bench.hertz = hertz;
    bench.with_latch("GevTimestampControlLatch", "GevTimestampValue");
    bench.camera.values["GevTimestampTickFrequency"] = fmt::format("{:.0f}", hertz);
    bench.device_clock = [](Timestamp at) {
      const nanoseconds since = at - Timestamp(1'699'999'990s);
      return since + since * 40 / 1'000'000;  // 40 ppm fast
    };
    ClockWatch watch(bench.camera, {}, bench.rig_clock());
    watch.begin();
    ClockState state;
    for (int second = 0; second < 20; ++second) {
      bench.now += 1s;
      state = watch.look();
    }
    EXPECT_EQ(state.kind, "model");
    EXPECT_TRUE(state.settled);
    EXPECT_LE(*state.error, 40us);
    EXPECT_LT(std::chrono::abs(*state.offset), 40us);
    const Timestamp moment = bench.now + 300ms;
    EXPECT_LT(std::chrono::abs(watch.map().rig_time(bench.device_clock(moment)) - moment), 40us) << hertz;
  }
}

TEST(ClockWatch, PtpCanBeLeftAloneAndACameraWithNothingHasNoClock) {
  Bench bench;
  bench.with_ptp("Slave");
  ClockWatch without_ptp(bench.camera, {.use_ptp = false}, bench.rig_clock());
  without_ptp.begin();
  EXPECT_EQ(without_ptp.look().kind, "model");
  EXPECT_EQ(bench.camera.values["PtpEnable"], "false");
  Bench dead;
  dead.camera.values = {{"TimestampLatchValue", "0"}};
  dead.camera.commands["TimestampLatch"] = [] {};
  ClockWatch of_dead_latch(dead.camera, {}, dead.rig_clock());
  of_dead_latch.begin();
  EXPECT_EQ(of_dead_latch.look().kind, "none") << "a latch that latches nothing";
  FakeFeatures bare;
  ClockWatch watch(bare, {}, bench.rig_clock());
  watch.begin();
  const auto state = watch.look();
  EXPECT_EQ(state.kind, "none");
  EXPECT_TRUE(state.settled);
}

ClockState slave(const std::string& grandmaster, const std::string& parent = "") {
  return {.kind = "ptp slave", .settled = true, .identity = "", .parent = parent, .grandmaster = grandmaster};
}
ClockState master(const std::string& identity) {
  return {.kind = "ptp master", .settled = true, .identity = identity};
}

TEST(PtpDomain, OneMasterFollowedByAllIsWellWhoeverItIs) {
  EXPECT_THAT(ptp_domain_problems({{"cam00", slave("77")}, {"cam01", slave("77")}}), IsEmpty());
  EXPECT_THAT(ptp_domain_problems({{"cam00", master("5")}, {"cam01", slave("", "5")}}), IsEmpty());
  EXPECT_THAT(ptp_domain_problems({{"cam00", master("")}, {"cam01", slave("")}}), IsEmpty()) << "they do not tell";
  EXPECT_THAT(ptp_domain_problems({{"cam00", {.kind = "model"}}, {"cam01", slave("7")}}), IsEmpty());
}

TEST(PtpDomain, SeveralMastersAreToldByName) {
  EXPECT_THAT(ptp_domain_problems({{"cam00", master("5")}, {"cam01", master("6")}}),
              testing::ElementsAre(HasSubstr("cam00 and cam01 are PTP masters")));
  const auto parted = ptp_domain_problems({{"cam00", slave("77")}, {"cam01", slave("78")}, {"cam02", slave("77")}});
  EXPECT_THAT(parted, testing::ElementsAre(testing::AllOf(HasSubstr("77 (cam00, cam02)"), HasSubstr("78 (cam01)"))));
  EXPECT_THAT(ptp_domain_problems({{"cam00", master("5")}, {"cam01", slave("", "9")}}), SizeIs(1));
  auto on_utc = slave("77");
  on_utc.moved = 37s;
  EXPECT_THAT(ptp_domain_problems({{"cam00", slave("77")}, {"cam01", on_utc}}),
              testing::ElementsAre(HasSubstr("some UTC (cam01)")));
}

TEST(GuessedClockShift, IsWhatExplainsHowLateAFrameSeemsToCome) {
  const Timestamp came(1'700'000'000s);
  EXPECT_EQ(guessed_clock_shift(came - 60ms, came), 0ns);
  EXPECT_EQ(guessed_clock_shift(came - 37s - 60ms, came), 37s);
  EXPECT_EQ(guessed_clock_shift(Timestamp(4s), came), came - Timestamp(4s));
}

}  // namespace
}  // namespace rotunda::capture
