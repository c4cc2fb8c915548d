#include "simulator/gige/gige_studio.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include "config/errors.h"
#include "tests/support/aravis_client.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"

namespace rotunda::simulator {
namespace {

using capture::RigClock;
using capture::Timestamp;
using tests::ActionSender;
using tests::AravisClient;
using tests::TestStudio;
using namespace std::chrono_literals;

class GigeStudioTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto refusal = tests::enter_private_network();
    if (!refusal.empty()) GTEST_SKIP() << refusal;
  }
};

// Complete frames with the pixels that belong to their time; nothing if one is not so.
void expect_frame(const std::optional<tests::ReceivedFrame>& frame, const TestStudio& studio, std::size_t camera,
                  Timestamp start) {
  ASSERT_TRUE(frame) << "camera " << camera << " sent nothing";
  EXPECT_EQ(frame->status, ARV_BUFFER_STATUS_SUCCESS) << "camera " << camera;
  EXPECT_EQ((frame->exposure_start - start).count(), 0) << "camera " << camera;
  EXPECT_EQ(frame->pixels, studio.picture(camera, start)) << "camera " << camera;
}

}  // namespace

TEST_F(GigeStudioTest, TenCamerasAnswerScheduledActionsWithTheScheduledTimeAndItsPixels) {
  TestStudio studio({.cameras = 10});
  std::vector<std::unique_ptr<AravisClient>> clients;
  for (std::size_t i = 0; i < 10; ++i) {
    clients.push_back(std::make_unique<AravisClient>(studio.address(i)));
    clients.back()->trigger_by("Action1");
    clients.back()->start();
  }
  ActionSender actions;
  const Timestamp first = RigClock::now() + 500ms;
  constexpr int kTriggers = 6;
  for (int k = 0; k < kTriggers; ++k) {
    const Timestamp at = first + k * 250ms;
    EXPECT_EQ(actions.send(at), std::vector<std::uint16_t>(10, 0));
    for (std::size_t i = 0; i < 10; ++i) expect_frame(clients[i]->next_frame(), studio, i, at);
  }
  for (const auto& stats : studio.stats()) {
    EXPECT_EQ(stats.triggers, kTriggers);
    EXPECT_EQ(stats.frames_sent, kTriggers);
    EXPECT_EQ(stats.late_actions, 0U);
  }
}

TEST_F(GigeStudioTest, SoftwareTriggerStampsTheMomentItCame) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0));
  client.trigger_by("Software");
  client.start();
  for (int k = 0; k < 3; ++k) {
    const Timestamp before = RigClock::now();
    client.execute("TriggerSoftware");
    const Timestamp after = RigClock::now();
    const auto frame = client.next_frame();
    ASSERT_TRUE(frame);
    EXPECT_GE(frame->exposure_start, before);
    EXPECT_LE(frame->exposure_start, after);
    expect_frame(frame, studio, 0, frame->exposure_start);
  }
  EXPECT_EQ(studio.stats()[0].triggers, 3U);
}

}  // namespace rotunda::simulator
