#include "simulator/gige/gige_studio.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <thread>

#include "config/errors.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/udp_socket.h"
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

constexpr int kPacketSize = 1500;

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
    clients.push_back(std::make_unique<AravisClient>(studio.address(i), kPacketSize));
    clients.back()->trigger_by("Action1");
    clients.back()->start();
  }
  ActionSender actions;
  const Timestamp first = RigClock::now() + 2s;  // a busy machine sends late
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
  AravisClient client(studio.address(0), kPacketSize);
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

TEST_F(GigeStudioTest, ImmediateActionStampsAllCamerasWithTheSameMoment) {
  TestStudio studio({.cameras = 3});
  std::vector<std::unique_ptr<AravisClient>> clients;
  for (std::size_t i = 0; i < 3; ++i) {
    clients.push_back(std::make_unique<AravisClient>(studio.address(i), kPacketSize));
    clients.back()->trigger_by("Action1");
    clients.back()->start();
  }
  EXPECT_EQ(ActionSender().send(std::nullopt, 3), std::vector<std::uint16_t>(3, 0));
  const auto first = clients[0]->next_frame();
  ASSERT_TRUE(first);
  for (std::size_t i = 1; i < 3; ++i) expect_frame(clients[i]->next_frame(), studio, i, first->exposure_start);
}

TEST_F(GigeStudioTest, FreeRunKeepsTheFrameRateExactly) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  client.set("TriggerMode", "Off");
  client.set_float("AcquisitionFrameRate", 5.0);
  client.start();
  const auto first = client.next_frame();
  ASSERT_TRUE(first);
  for (int k = 1; k < 5; ++k) expect_frame(client.next_frame(), studio, 0, first->exposure_start + k * 200ms);
  client.stop();
  EXPECT_FALSE((*studio).stats()[0].is_acquiring);
}

TEST_F(GigeStudioTest, ResendCompletesEveryFrameUnderOnePercentLoss) {
  TestStudio studio({.cameras = 2, .width = 640, .height = 480});  // 212 packets a frame
  (*studio).set_faults({.seed = 3, .packet_loss = {.rate = 0.01}});
  std::vector<std::unique_ptr<AravisClient>> clients;
  for (std::size_t i = 0; i < 2; ++i) {
    clients.push_back(std::make_unique<AravisClient>(studio.address(i), kPacketSize));
    clients.back()->trigger_by("Action1");
    // A loaded machine may need long to ask and to answer; what is tested is that nothing stays lost.
    clients.back()->start({.frame_retention = 3s});
  }
  ActionSender actions;
  const Timestamp first = RigClock::now() + 300ms;
  constexpr int kTriggers = 12;
  for (int k = 0; k < kTriggers; ++k) {
    const Timestamp at = std::max(first + k * 200ms, RigClock::now() + 200ms);
    ASSERT_EQ(actions.send(at, 2), std::vector<std::uint16_t>(2, 0));
    for (std::size_t i = 0; i < 2; ++i) expect_frame(clients[i]->next_frame(), studio, i, at);
  }
  for (const auto& stats : studio.stats()) {
    EXPECT_GT(stats.packets_lost, 0U) << "the fault did not happen";
    EXPECT_GT(stats.packets_resent, 0U);
    EXPECT_GT(stats.resend_requests, 0U);
  }
}

TEST_F(GigeStudioTest, ASecondControllerIsRefusedAndTheFirstStreamsOn) {
  TestStudio studio({.cameras = 1});
  AravisClient first(studio.address(0), kPacketSize);
  first.trigger_by("Software");
  first.start();
  AravisClient second(studio.address(0));
  EXPECT_FALSE(second.is_controller());
  EXPECT_EQ(second.text("DeviceUserID"), "cam00");
  EXPECT_THROW(second.set("TriggerMode", "Off"), std::runtime_error);
  EXPECT_GT(studio.stats()[0].denied, 0U);
  first.execute("TriggerSoftware");
  const auto frame = first.next_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->status, ARV_BUFFER_STATUS_SUCCESS);
}

TEST_F(GigeStudioTest, AControllerWithoutHeartbeatLosesTheCameraToTheNext) {
  TestStudio studio({.cameras = 1});
  UdpSocket vanishing({.address = INADDR_LOOPBACK, .port = 0});
  const std::vector<std::uint8_t> take_control{0, 0, 0x0A, 0, 0, 0, 0, 2}, shorter{0, 0, 0x09, 0x38, 0, 0, 0x02, 0x58};
  vanishing.send(gvcp_command(GvcpOpcode::write_register, kAckWanted, 1, take_control), {INADDR_LOOPBACK, kGvcpPort});
  vanishing.send(gvcp_command(GvcpOpcode::write_register, kAckWanted, 2, shorter), {INADDR_LOOPBACK, kGvcpPort});
  const auto wait_for = [&](auto condition) {
    for (int k = 0; k < 1000 && !condition(studio.stats()[0]); ++k) std::this_thread::sleep_for(10ms);
    return condition(studio.stats()[0]);
  };
  EXPECT_TRUE(wait_for([](const GigeStats& stats) { return stats.has_controller || stats.lost_controllers == 1; }));
  EXPECT_TRUE(wait_for([](const GigeStats& stats) { return stats.lost_controllers == 1; }));
  AravisClient next(studio.address(0), kPacketSize);
  EXPECT_TRUE(next.is_controller());
}

TEST_F(GigeStudioTest, FeaturesReadAndWriteThroughGenicam) {
  TestStudio studio({.cameras = 2});
  AravisClient client(studio.address(1), kPacketSize);
  EXPECT_EQ(client.text("DeviceSerialNumber"), "RS0001");
  EXPECT_EQ(client.text("DeviceUserID"), "cam01");
  EXPECT_EQ(client.text("PixelFormat"), "BayerRG8");
  EXPECT_EQ(client.text("PtpStatus"), "Slave");
  EXPECT_EQ(client.integer("PtpOffsetFromMaster"), 0);
  EXPECT_EQ(client.integer("Width"), 160);
  EXPECT_EQ(client.integer("PayloadSize"), 160 * 120);
  EXPECT_EQ(client.integer("GevSCPSPacketSize"), 1500);
  EXPECT_EQ(client.integer("GevTimestampTickFrequency"), 1'000'000'000);
  EXPECT_NEAR(client.real("DeviceTemperature"), 41.5, 1e-6);
  client.set_float("ExposureTime", 1234.5);
  EXPECT_NEAR(client.real("ExposureTime"), 1234.5, 1e-9);
  client.set_float("Gain", 6.25);
  EXPECT_NEAR(client.real("Gain"), 6.25, 1e-9);
  client.set_integer("ActionDeviceKey", 0xFEDCBA98);
  EXPECT_EQ(client.integer("ActionDeviceKey"), 0xFEDCBA98);
  client.set("PixelFormat", "Mono8");
  EXPECT_EQ(client.text("PixelFormat"), "Mono8");
  client.set("DeviceUserID", "left");
  EXPECT_EQ(client.text("DeviceUserID"), "left");
  EXPECT_THROW(client.set("PixelFormat", "RGB8"), std::runtime_error);
  const auto before = RigClock::now().time_since_epoch().count();
  client.execute("TimestampLatch");
  EXPECT_GE(client.integer("TimestampLatchValue"), before);
  EXPECT_LE(client.integer("TimestampLatchValue"), RigClock::now().time_since_epoch().count());
}

TEST_F(GigeStudioTest, AravisFindsTheLargestPacketByTestPackets) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  arv_camera_gv_set_packet_size_adjustment(client.camera(), ARV_GV_PACKET_SIZE_ADJUSTMENT_ALWAYS);
  client.trigger_by("Software");
  client.start();
  EXPECT_GT(client.integer("GevSCPSPacketSize"), 9000);  // the loopback carries 64 KiB
  client.execute("TriggerSoftware");
  const auto frame = client.next_frame();
  ASSERT_TRUE(frame);
  expect_frame(frame, studio, 0, frame->exposure_start);
}

TEST_F(GigeStudioTest, ASilentCameraIsLostWhileTheOthersGoOnAndComesBack) {
  TestStudio studio({.cameras = 2});
  std::vector<std::unique_ptr<AravisClient>> clients;
  for (std::size_t i = 0; i < 2; ++i) {
    clients.push_back(std::make_unique<AravisClient>(studio.address(i), kPacketSize));
    clients.back()->trigger_by("Action1");
    clients.back()->start();
  }
  ActionSender actions;
  (*studio).set_faults(1, {.silent = true});
  const Timestamp lost = RigClock::now() + 200ms;
  EXPECT_EQ(actions.send(lost, 1).size(), 1U);
  expect_frame(clients[0]->next_frame(), studio, 0, lost);
  EXPECT_FALSE(clients[1]->next_frame(300ms));
  (*studio).set_faults(1, {});
  const Timestamp back = RigClock::now() + 200ms;
  EXPECT_EQ(actions.send(back, 2).size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) expect_frame(clients[i]->next_frame(), studio, i, back);
  EXPECT_THROW((*studio).set_faults(2, {}), InvalidInput);
}

TEST_F(GigeStudioTest, LateFramesKeepTheStampOfTheirLineEdge) {
  TestStudio studio({.cameras = 1});
  (*studio).set_faults({.late_frames = {300ms}});
  AravisClient client(studio.address(0), kPacketSize);
  client.trigger_by("Line0");
  client.start();
  const Timestamp edge = RigClock::now() + 20ms;
  (*studio).line0_edge(edge);
  expect_frame(client.next_frame(), studio, 0, edge);
  EXPECT_GE(RigClock::now() - edge, 300ms);
}

TEST_F(GigeStudioTest, TellsWhoseAddressIsTaken) {
  TestStudio studio({.cameras = 3, .first_address = 3});
  try {
    TestStudio other({.cameras = 5});
    FAIL() << "two studios share an address";
  } catch (const DeviceError& error) {
    EXPECT_STREQ(error.what(), "cam02: 127.0.0.3:3956 is taken; is another rotunda-sim running?");
  }
}

TEST_F(GigeStudioTest, RefusesTwoCamerasOfOneSerial) {
  std::vector<GigeCameraOptions> cameras(2);
  cameras[1] = {.name = "cam01", .serial = cameras[0].serial, .address = "127.0.0.2", .mac = {2, 0, 0, 0, 0, 2}};
  EXPECT_THROW(GigeStudio(cameras, nullptr), InvalidInput);
  cameras[1].serial = "RS0001";
  cameras[1].address = "192.0.2.1";
  EXPECT_THROW(GigeStudio(cameras, nullptr), DeviceError);
}

TEST_F(GigeStudioTest, ACameraWithoutAPictureSkipsTheFrameAndCountsIt) {
  GigeStudio studio({GigeCameraOptions{}}, [](std::size_t, Timestamp) -> std::span<const std::uint8_t> {
    throw std::runtime_error("the act is over");
  });
  studio.start();
  AravisClient client("127.0.0.1", kPacketSize);
  client.trigger_by("Software");
  client.start();
  client.execute("TriggerSoftware");
  for (int k = 0; k < 1000 && studio.stats()[0].missing_pictures == 0; ++k) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(studio.stats()[0].missing_pictures, 1U);
}

TEST_F(GigeStudioTest, TellsTheExposureBehindEachFrame) {
  const std::vector<std::uint8_t> pixels(720 * 576);
  std::mutex mutex;
  std::vector<Exposure> told;
  GigeStudio studio({GigeCameraOptions{}}, [&](std::size_t, Timestamp) { return std::span{pixels}; },
                    {.on_exposure = [&](const Exposure& exposure) {
                      const std::scoped_lock lock(mutex);
                      told.push_back(exposure);
                    }});
  studio.start();
  AravisClient client("127.0.0.1", kPacketSize);
  client.set_float("ExposureTime", 1250.0);
  client.trigger_by("Software");
  client.start();
  client.execute("TriggerSoftware");
  const auto frame = client.next_frame();
  ASSERT_TRUE(frame);
  const std::scoped_lock lock(mutex);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].camera, 0U);
  EXPECT_EQ(told[0].block, frame->block);
  EXPECT_EQ(told[0].start, frame->exposure_start);
  EXPECT_EQ(told[0].duration, 1250us);
}

TEST_F(GigeStudioTest, AnIndependentToolListsAndReadsTheCameras) {
  TestStudio studio({.cameras = 10});
  const auto listed = tests::output_of("arv-tool-0.8 2>&1");
  if (listed.find("not found") != std::string::npos) GTEST_SKIP() << "arv-tool-0.8 is not installed";
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_NE(listed.find(fmt::format("RS{:04} ({})", i, studio.address(i))), std::string::npos) << listed;
  const auto read = tests::output_of("arv-tool-0.8 -a 127.0.0.7 control Width PixelFormat DeviceUserID 2>&1");
  EXPECT_THAT(read, testing::HasSubstr("Width = 160"));
  EXPECT_THAT(read, testing::HasSubstr("BayerRG8"));
  EXPECT_THAT(read, testing::HasSubstr("cam06"));
}

}  // namespace rotunda::simulator
