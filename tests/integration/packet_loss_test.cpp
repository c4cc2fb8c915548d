// Packets that get lost on the way between the cameras and a daemon that records.
#include "capture/take/take_reader.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

using nlohmann::json;
using simulator::FaultKind;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::size_t kCameras = 3;
constexpr int kPackets = 39;  // a frame, in packets of 600 bytes: leader, 37 of pixels, trailer
constexpr int kFrameSets = 60;

class PacketLoss : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    studio_.emplace(TestStudioOptions{.cameras = kCameras, .width = kWidth, .height = kHeight});
    daemon_ = start_daemon(write_rig({.cameras = kCameras, .packet_size = 600, .rate_hz = 10.0}));
    wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming streaming"; });
  }

  void lose(double share) { (**studio_).set_faults({.seed = 11, .packet_loss = {.rate = share, .burst = 8}}); }

  // Packets that did not leave, and packets that left again.
  struct Losses {
    std::uint64_t lost = 0, resent = 0, requests = 0;
  };
  Losses losses() const {
    Losses all;
    for (const auto& camera : studio_->stats()) {
      all.lost += camera.faults[FaultKind::packet_loss];
      all.resent += camera.packets_resent;
      all.requests += camera.resend_requests;
    }
    return all;
  }

  void expect_true_pictures(const std::string& name) const {
    const capture::TakeReader take(takes() / name);
    for (std::size_t set = 0; set < take.frame_set_count(); ++set)
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        const auto slot = take.read(set, camera);
        ASSERT_TRUE(slot.frame) << "frame set " << set;
        const auto seen = studio_->picture(camera, slot.frame->exposure_start);
        const auto kept = slot.frame->image.bytes();
        ASSERT_TRUE(std::equal(kept.begin(), kept.end(), seen.begin(), seen.end())) << "frame set " << set;
      }
  }

  std::optional<TestStudio> studio_;
  std::unique_ptr<ScopedProgram> daemon_;
};

TEST_F(PacketLoss, OfOnePercentInBurstsOfEightCostsNoFrame) {
  const auto frames = std::to_string(kFrameSets);
  ASSERT_EQ(rotunda({"take", "start", "control", "--frames", frames}).exit_code, 0);
  EXPECT_EQ(losses().lost, 0U);
  EXPECT_EQ(losses().requests, 0U) << "nothing is asked for again while nothing is lost";
  EXPECT_EQ(status()["cameras"][0]["problem"], "");

  lose(0.01);
  const auto taken = rotunda({"take", "start", "lossy", "--frames", frames});
  EXPECT_EQ(taken.exit_code, 0) << taken.out << taken.err;
  const auto report = verify("lossy", 0);
  EXPECT_EQ(report["complete"], kFrameSets) << report.dump(2);
  const auto all = losses();
  const double packets = kCameras * kFrameSets * kPackets;
  EXPECT_GE(static_cast<double>(all.lost), 0.004 * packets) << "dozens of packets were lost, in bursts";
  EXPECT_GE(all.resent + 8, all.lost) << "and each came again";
  expect_true_pictures("lossy");
}

TEST_F(PacketLoss, BeyondTheBudgetIsToldWithItsCauseAndStopsAsking) {
  lose(0.6);
  ASSERT_EQ(rotunda({"rig", "live"}).exit_code, 0);
  const auto told = wait_for_status([](const json& now) {
    return now["cameras"][0]["problem"].get<std::string>().find("resend_budget_percent") != std::string::npos;
  });
  EXPECT_THAT(told["cameras"][0]["problem"].get<std::string>(),
              AllOf(HasSubstr("lost on the way and asked for again"), HasSubstr("paused"), HasSubstr("cable, switch")));
  EXPECT_GT(losses().lost, 0U);
  lose(0.0);
  ASSERT_EQ(rotunda({"rig", "live", "--off"}).exit_code, 0);
  EXPECT_EQ(rotunda({"take", "start", "after", "--frames", "10"}).exit_code, 0);
  EXPECT_EQ(verify("after", 0)["complete"], 10);
}

}  // namespace
}  // namespace rotunda::tests
