// Cameras that share a clock by IEEE 1588 (PTP), through the daemon: when it is there, when it counts another time
// scale than the rig, and when it is not one clock.
#include <fmt/format.h>

#include <mutex>

#include "capture/sync/clock_watch.h"
#include "capture/take/take_reader.h"
#include "simulator/gige/gige_studio.h"
#include "tests/integration/house_test.h"

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;
using capture::Timestamp;
using nlohmann::json;
using simulator::FaultKind;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::size_t kCameras = 3;
constexpr int kFrameSets = 6;
constexpr std::chrono::nanoseconds kWander = 120ns;  // of a slave about its master

// Cameras on one PTP domain, and when each of them truly exposed, whatever its clock said.
class PtpStudio {
 public:
  PtpStudio() : studio_(cameras(), [this](std::size_t camera, Timestamp start) { return expose(camera, start); }) {
    studio_.start();
  }
  simulator::GigeStudio& operator*() { return studio_; }
  std::vector<std::vector<Timestamp>> exposures() const {
    const std::lock_guard lock(mutex_);
    return exposures_;
  }
  std::uint64_t clock_steps(std::size_t camera) const { return studio_.stats()[camera].faults[FaultKind::clock_step]; }

 private:
  static std::vector<simulator::GigeCameraOptions> cameras() {
    std::vector<simulator::GigeCameraOptions> all;
    for (std::size_t i = 0; i < kCameras; ++i)
      all.push_back({.name = fmt::format("cam{:02}", i),
                     .serial = fmt::format("RS{:04}", i),
                     .address = fmt::format("127.0.0.{}", i + 1),
                     .mac = {0x02, 0x52, 0x54, 0, 0, static_cast<std::uint8_t>(i + 1)},
                     .width = kWidth,
                     .height = kHeight,
                     .clock = {.ptp = true, .drift_ppm = 20.0, .wander = kWander, .seed = i}});
    return all;
  }
  std::span<const std::uint8_t> expose(std::size_t camera, Timestamp start) {
    const std::lock_guard lock(mutex_);
    exposures_[camera].push_back(start);
    return picture_;
  }

  mutable std::mutex mutex_;
  std::vector<std::vector<Timestamp>> exposures_ = std::vector<std::vector<Timestamp>>(kCameras);
  std::vector<std::uint8_t> picture_ = std::vector<std::uint8_t>(kWidth * kHeight, 100);
  simulator::GigeStudio studio_;  // last: its threads use the rest
};

class Ptp : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    studio_.emplace();
  }
  // A camera's clock counts UTC instead of TAI from now on.
  void put_on_utc(std::size_t camera) {
    (**studio_).add_fault(camera, {.effect = simulator::ClockStep{-capture::kTaiLessUtc}}, {});
  }
  void serve(int lead_periods = 4) {
    daemon_ = start_daemon(write_rig({.cameras = kCameras, .lead_periods = lead_periods}));
    wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming streaming"; });
  }

  // Every frame there, at its trigger's moment.
  void expect_in_step(const std::string& name) const {
    const capture::TakeReader take(takes() / name);
    ASSERT_EQ(take.frame_set_count(), static_cast<std::size_t>(kFrameSets));
    for (std::size_t set = 0; set < take.frame_set_count(); ++set)
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        const auto slot = take.read(set, camera);
        ASSERT_TRUE(slot.frame) << to_string(*slot.missing_because);
        EXPECT_LE(std::chrono::abs(slot.frame->exposure_start - take.time_of(set)), 1us);
      }
    EXPECT_LE(take.info().sync.spread_p99, 1us);
  }

  // How far apart the cameras truly exposed, at most.
  std::chrono::nanoseconds largest_spread() const {
    const auto starts = studio_->exposures();
    std::chrono::nanoseconds largest{};
    for (std::size_t k = 0; k < starts[0].size(); ++k) {
      Timestamp first = starts[0][k], last = first;
      for (const auto& camera : starts) {
        if (k >= camera.size()) return std::chrono::hours(1);
        first = std::min(first, camera[k]);
        last = std::max(last, camera[k]);
      }
      largest = std::max<std::chrono::nanoseconds>(largest, last - first);
    }
    return largest;
  }

  std::optional<PtpStudio> studio_;
  std::unique_ptr<ScopedProgram> daemon_;
};

TEST_F(Ptp, OneMasterAndItsSlavesExposeWithinAMicrosecondAndTheDaemonTellsTheirOffsets) {
  serve();
  const auto now =
      wait_for_status([](const json& status) { return !status["cameras"][1]["clock_offset_us"].is_null(); });
  EXPECT_EQ(now["cameras"][0]["clock"], "ptp master");
  for (const std::size_t camera : {1U, 2U}) {
    EXPECT_EQ(now["cameras"][camera]["clock"], "ptp slave");
    EXPECT_LT(std::abs(now["cameras"][camera]["clock_offset_us"].get<double>()), 1.0);
    EXPECT_EQ(now["cameras"][camera]["problem"], "");
  }
  EXPECT_TRUE(now["warnings"].empty()) << now["warnings"].dump();
  const auto taken = rotunda({"take", "start", "step", "--frames", std::to_string(kFrameSets)});
  ASSERT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  expect_in_step("step");
  EXPECT_EQ(studio_->exposures()[0].size(), static_cast<std::size_t>(kFrameSets));
  EXPECT_GT(largest_spread(), 0ns) << "slaves wander";
  EXPECT_LT(largest_spread(), 1us);
}

TEST_F(Ptp, ADomainThatCountsUtcIsMovedToTaiAndItsTriggersAreScheduledInUtc) {
  for (std::size_t camera = 0; camera < kCameras; ++camera) put_on_utc(camera);
  serve();
  const auto now = status();
  for (const auto& camera : now["cameras"])
    EXPECT_THAT(camera["problem"].get<std::string>(), AllOf(HasSubstr("37"), HasSubstr("UTC"))) << camera.dump(2);
  const auto taken = rotunda({"take", "start", "utc", "--frames", std::to_string(kFrameSets)});
  ASSERT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  for (std::size_t camera = 0; camera < kCameras; ++camera) EXPECT_GT(studio_->clock_steps(camera), 0U);
  expect_in_step("utc");
  const capture::TakeReader take(takes() / "utc");
  const auto truth = studio_->exposures();
  ASSERT_EQ(truth[0].size(), static_cast<std::size_t>(kFrameSets));
  for (std::size_t set = 0; set < static_cast<std::size_t>(kFrameSets); ++set)
    EXPECT_LE(std::chrono::abs(take.time_of(set) - truth[0][set]), 1ms) << "TAI, as the simulator's clock";
}

TEST_F(Ptp, CamerasOnTwoTimeScalesAreNotTriggeredTogether) {
  put_on_utc(2);
  serve();
  wait_for_status([](const json& now) { return !now["warnings"].empty(); });
  const auto refused = rotunda({"take", "start", "torn", "--frames", "2"});
  EXPECT_EQ(refused.exit_code, 4) << refused.out;
  EXPECT_THAT(refused.err, AllOf(HasSubstr("would not be in step"), HasSubstr("UTC"), HasSubstr("cam02")));
  EXPECT_GT(studio_->clock_steps(2), 0U);
  EXPECT_TRUE(contents_of(takes()).empty());
  (**studio_).clear_faults(2);
  wait_for_status([](const json& now) { return now["warnings"].empty(); });
  EXPECT_EQ(rotunda({"take", "start", "whole", "--frames", std::to_string(kFrameSets)}).exit_code, 0);
  expect_in_step("whole");
}

TEST_F(Ptp, CamerasWithoutACommonClockAreTriggeredByActionsThatAreCarriedOutOnArrival) {
  put_on_utc(2);
  serve(/*lead_periods=*/0);
  wait_for_status([](const json& now) { return !now["warnings"].empty(); });
  const auto taken = rotunda({"take", "start", "arrival", "--frames", std::to_string(kFrameSets)});
  EXPECT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  EXPECT_EQ(verify("arrival", 0)["complete"], kFrameSets);
  EXPECT_GT(studio_->clock_steps(2), 0U);
  const capture::TakeReader take(takes() / "arrival");
  const auto truth = studio_->exposures();
  for (const auto& camera : truth) {
    ASSERT_EQ(camera.size(), static_cast<std::size_t>(kFrameSets));
    for (std::size_t set = 0; set < camera.size(); ++set)
      EXPECT_GT(camera[set], take.time_of(set)) << "sent at the moment, not scheduled for it";
  }
}

}  // namespace
}  // namespace rotunda::tests
