// Faults as an unmodified Aravis sees them. Each claim stands beside the fault's counter and a part of the same test
// without the fault.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "config/errors.h"
#include "simulator/gige/fault_control.h"
#include "tests/support/aravis_client.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"

namespace rotunda::simulator {
namespace {

using capture::RigClock;
using capture::Timestamp;
using nlohmann::json;
using testing::HasSubstr;
using tests::ActionSender;
using tests::AravisClient;
using tests::TestStudio;
using namespace std::chrono_literals;

constexpr int kPacketSize = 1500;  // 160 x 120 pixels: 14 packets and leader and trailer

class GigeFaultsTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto refusal = tests::enter_private_network();
    if (!refusal.empty()) GTEST_SKIP() << refusal;
    studio.emplace(tests::TestStudioOptions{.cameras = 1});
    actions.emplace();  // its socket belongs into the private network too
  }

  // A loaded machine may need long to ask for what is missing and to answer.
  void open(std::chrono::microseconds frame_retention = 2s) {
    client = std::make_unique<AravisClient>(studio->address(0), kPacketSize);
    client->trigger_by("Action1");
    client->start({.frame_retention = frame_retention});
  }
  // One scheduled trigger and the frame that comes of it.
  std::optional<tests::ReceivedFrame> frame(std::chrono::microseconds patience = 10s) {
    last = std::max(last + 60ms, RigClock::now() + 150ms);
    EXPECT_EQ(actions->send(last, 1), std::vector<std::uint16_t>{0});
    return client->next_frame(patience);
  }
  void expect_whole(const std::optional<tests::ReceivedFrame>& received, Timestamp start) {
    ASSERT_TRUE(received) << "nothing came";
    EXPECT_EQ(received->status, ARV_BUFFER_STATUS_SUCCESS);
    EXPECT_EQ((received->exposure_start - start).count(), 0);
    EXPECT_EQ(received->pixels, studio->picture(0, start));
  }
  void expect_whole_frames(int count) {
    for (int k = 0; k < count; ++k) {
      const auto received = frame();  // before `last` is read
      expect_whole(received, last);
    }
  }
  void add(const FaultEffect& effect, std::optional<std::chrono::nanoseconds> lasts = {},
           std::optional<std::uint64_t> triggers = {}) {
    (**studio).add_fault(0, {.effect = effect, .lasts = lasts, .triggers = triggers}, RigClock::now());
  }
  void clear() { (**studio).clear_faults(0); }
  std::uint64_t fired(FaultKind kind) { return studio->stats()[0].faults[kind]; }
  template <class Condition>
  bool wait_for(Condition condition) {
    for (int k = 0; k < 2000 && !condition(); ++k) std::this_thread::sleep_for(10ms);
    return condition();
  }

  std::optional<TestStudio> studio;
  std::unique_ptr<AravisClient> client;
  std::optional<ActionSender> actions;
  Timestamp last;
};

}  // namespace

TEST_F(GigeFaultsTest, ResendsRecoverBurstsOfLostPackets) {
  open();
  expect_whole_frames(2);
  EXPECT_EQ(studio->stats()[0].resend_requests, 0U);
  add(PacketLoss{.rate = 0.2, .burst = 3});
  expect_whole_frames(6);
  EXPECT_GT(fired(FaultKind::packet_loss), 0U);
  EXPECT_GE(studio->stats()[0].packets_resent, 1U);
}

TEST_F(GigeFaultsTest, ReorderedAndDoubledPacketsDoNoHarm) {
  open();
  expect_whole_frames(1);
  add(Reorder{.rate = 0.3, .by = 2});
  add(Duplicate{.rate = 0.3});
  expect_whole_frames(5);
  EXPECT_GT(fired(FaultKind::reorder), 0U);
  EXPECT_GT(fired(FaultKind::duplicate), 0U);
}

TEST_F(GigeFaultsTest, RefusedPacketsAndMissingTrailersAreAskedForAgain) {
  open();
  add(NetworkError{.rate = 0.1});
  add(MissingTrailer{.rate = 0.5});
  expect_whole_frames(5);
  EXPECT_GT(fired(FaultKind::network_error), 0U);
  EXPECT_GT(fired(FaultKind::missing_trailer), 0U);
}

TEST_F(GigeFaultsTest, ASilentCameraIsSeenAsControlLost) {
  std::atomic<int> losses = 0;
  open();
  g_signal_connect(client->device(), "control-lost",
                   G_CALLBACK(+[](ArvGvDevice*, std::atomic<int>* count) { ++*count; }), &losses);
  expect_whole_frames(1);
  std::this_thread::sleep_for(1500ms);  // a heartbeat passes
  EXPECT_EQ(losses, 0);
  add(Silence{});
  EXPECT_TRUE(wait_for([&] { return losses > 0; }));
  EXPECT_GT(fired(FaultKind::silence), 0U);
  clear();
}

TEST_F(GigeFaultsTest, ARebootedCameraIsAwayThenFoundAgainAsAtPowerUp) {
  open();
  client->set_float("Gain", 7.0);
  expect_whole_frames(1);
  client.reset();
  add(Reboot{}, 3s);
  EXPECT_THROW(AravisClient(studio->address(0)), std::runtime_error) << "it is away";
  ASSERT_TRUE(wait_for([&] { return studio->stats()[0].in_force.empty(); }));
  open();
  EXPECT_EQ(client->real("Gain"), 0.0);
  client->set("TriggerSource", "Software");  // the clock is not synchronised yet
  client->execute("TriggerSoftware");
  const auto received = client->next_frame();
  ASSERT_TRUE(received);
  EXPECT_EQ(received->status, ARV_BUFFER_STATUS_SUCCESS);
  EXPECT_EQ(fired(FaultKind::reboot), 1U);
}

TEST_F(GigeFaultsTest, StolenControlDeniesTheClientUntilItIsGivenBack) {
  open();
  EXPECT_NO_THROW(client->set_float("Gain", 1.0));
  add(ControlStolen{});
  EXPECT_THROW(client->set_float("Gain", 2.0), std::runtime_error);
  EXPECT_THROW(client->real("Gain"), std::runtime_error) << "exclusive";
  EXPECT_EQ(fired(FaultKind::control_stolen), 1U);
  client.reset();
  clear();
  ASSERT_TRUE(wait_for([&] { return !studio->stats()[0].has_controller; }));
  open();
  expect_whole_frames(1);
}

TEST_F(GigeFaultsTest, MissedDoubledAndLateTriggersAppearInTheStamps) {
  open();
  add(MissedTrigger{.every = 1}, {}, 1);
  EXPECT_FALSE(frame(400ms));
  expect_whole_frames(1);
  add(DoubledTrigger{.every = 1, .after = 20ms}, {}, 1);
  const auto first = frame();
  expect_whole(first, last);
  expect_whole(client->next_frame(), last + 20ms);
  add(LateTrigger{.by = 7ms}, {}, 1);
  const auto late = frame();
  expect_whole(late, last + 7ms);
  expect_whole_frames(1);
  for (const auto kind : {FaultKind::missed_trigger, FaultKind::doubled_trigger, FaultKind::late_trigger})
    EXPECT_EQ(fired(kind), 1U) << to_string(kind);
}

TEST_F(GigeFaultsTest, AStalledStreamEndsAndTheControlChannelAnswers) {
  open();
  add(Stall{}, {}, 2);
  EXPECT_FALSE(frame(400ms));
  EXPECT_EQ(client->integer("Width"), 160);
  EXPECT_FALSE(frame(400ms));
  expect_whole_frames(2);
  EXPECT_EQ(fired(FaultKind::stall), 2U);
}

TEST_F(GigeFaultsTest, AnOverheatedCameraTellsItsTemperatureAndStops) {
  open();
  EXPECT_LT(client->real("DeviceTemperature"), 60.0);
  add(OverTemperature{.celsius = 91.0, .stops_at = 85.0});
  EXPECT_NEAR(client->real("DeviceTemperature"), 91.0, 1e-3);
  EXPECT_FALSE(frame(400ms));
  EXPECT_GE(fired(FaultKind::over_temperature), 2U);
  clear();
  expect_whole_frames(1);
}

TEST_F(GigeFaultsTest, AClockThatStepsMakesExposuresEarlyAndStampsRight) {
  open();
  add(ClockStep{.by = 5ms});
  const auto stepped = frame();
  ASSERT_TRUE(stepped);
  EXPECT_EQ((stepped->exposure_start - last).count(), 0) << "the camera believes it was in time";
  EXPECT_EQ(stepped->pixels, studio->picture(0, last - 5ms)) << "what it saw is of 5 ms before";
  EXPECT_EQ(fired(FaultKind::clock_step), 1U);
}

TEST_F(GigeFaultsTest, SlowRegistersAreAnsweredLateButAnswered) {
  open();
  const auto seconds_of_read = [&] {
    const auto before = std::chrono::steady_clock::now();
    EXPECT_EQ(client->integer("Width"), 160);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  };
  seconds_of_read();
  EXPECT_EQ(fired(FaultKind::slow_registers), 0U);
  add(SlowRegisters{.by = 150ms});
  EXPECT_GE(seconds_of_read(), 0.15);
  EXPECT_GT(fired(FaultKind::slow_registers), 0U);
  clear();
  expect_whole_frames(1);
}

// Aravis must not crash, and the frames after must be whole; what it makes of the lie is its own business.
TEST_F(GigeFaultsTest, LiesOfLeadersAndLengthsDoNotOutlastTheirFrames) {
  open(400ms);
  const auto lie = [&](const FaultEffect& effect) {
    add(effect, {}, 1);
    frame(200ms);
    while (client->next_frame(600ms)) continue;  // what was held up behind it
    expect_whole_frames(1);
  };
  for (const auto flaw : {LeaderFlaw::width, LeaderFlaw::height, LeaderFlaw::pixel_format, LeaderFlaw::random})
    lie(CorruptedLeader{.flaw = flaw, .rate = 1.0});
  EXPECT_GE(fired(FaultKind::corrupted_leader), 4U);
  lie(WrongPayloadSize{.sent_change = -5000});
  lie(WrongPayloadSize{.sent_change = 5000});
  EXPECT_EQ(fired(FaultKind::wrong_payload_size), 2U);
  const auto honest = client->integer("PayloadSize");
  add(WrongPayloadSize{.register_change = 4096});
  EXPECT_EQ(client->integer("PayloadSize"), honest + 4096);
}

// Aravis 0.8.26 takes all lower block ids for late ones from then on; only a new stream heals it.
TEST_F(GigeFaultsTest, AFarBlockIdIsOverWithTheStream) {
  open(400ms);
  add(CorruptedLeader{.flaw = LeaderFlaw::block_id, .rate = 1.0}, {}, 1);
  frame(200ms);
  EXPECT_GE(fired(FaultKind::corrupted_leader), 1U);
  client.reset();
  open();
  expect_whole_frames(2);
}

TEST_F(GigeFaultsTest, RequestsAreAnsweredInJson) {
  const std::vector<std::string> names{"cam00"};
  const auto ask = [&](const std::string& line) { return json::parse(answer_fault_request(**studio, names, line)); };
  EXPECT_EQ(ask("cam00: { missed_trigger: { every: 1 } }"), (json{{"ok", true}, {"added", 1}}));
  open();
  EXPECT_FALSE(frame(300ms));
  const auto status = ask("status");
  EXPECT_EQ(status["faults"]["missed_trigger"], 1);
  EXPECT_EQ(status["cameras"][0]["name"], "cam00");
  EXPECT_EQ(status["cameras"][0]["in_force"], json{"missed_trigger"});
  EXPECT_EQ(status["cameras"][0]["triggers"], 1);
  EXPECT_EQ(fault_summary(studio->stats(), names), "cam00: missed_trigger 1");
  EXPECT_EQ(ask("clear: cam00")["cleared"], 1);
  expect_whole_frames(1);
  const auto refused = ask("cam01: { silence: 2s }");
  EXPECT_EQ(refused["ok"], false);
  EXPECT_THAT(refused["error"], HasSubstr("cam01: unknown; expected all, or cameras out of cam00"));
  EXPECT_EQ(ask("\xff\xfe")["ok"], false);
  EXPECT_EQ(ask("help")["faults"].size(), kFaultKinds);
}

TEST_F(GigeFaultsTest, RefusesCamerasThatAreNotThereAndMoreFaultsThanItKeeps) {
  EXPECT_THROW((**studio).add_fault(1, {.effect = Stall{}}, RigClock::now()), InvalidInput);
  EXPECT_THROW((**studio).clear_faults(7), InvalidInput);
  for (std::size_t i = 0; i < FaultSchedule::kMaxFaults; ++i) add(Stall{});
  EXPECT_THROW(add(Stall{}), InvalidInput);
  EXPECT_EQ(fault_summary(studio->stats(), {"cam00"}), "no fault fired");
}

}  // namespace rotunda::simulator
