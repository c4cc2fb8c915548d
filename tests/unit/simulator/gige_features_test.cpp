// The camera's features through unmodified Aravis.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "simulator/gige/chunk_data.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/genicam_xml.h"
#include "simulator/gige/region.h"
#include "simulator/gige/trigger_box.h"
#include "tests/support/aravis_client.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"

namespace rotunda::simulator {
namespace {

using capture::RigClock;
using capture::Timestamp;
using tests::AravisClient;
using tests::AravisError;
using tests::TestStudio;
using namespace std::chrono_literals;

constexpr int kPacketSize = 1500;

class GigeFeatures : public testing::Test {
 protected:
  void SetUp() override {
    const auto refusal = tests::enter_private_network();
    if (!refusal.empty()) GTEST_SKIP() << refusal;
  }
};

void set_boolean(AravisClient& client, const char* feature, bool value) {
  AravisError error;
  arv_camera_set_boolean(client.camera(), feature, value, error);
  error.check(feature);
}

}  // namespace

TEST_F(GigeFeatures, TheDescriptionComesZippedAndWhole) {
  TestStudio studio({.cameras = 1});
  const AravisClient client(studio.address(0));
  std::size_t bytes = 0;
  const char* xml = arv_device_get_genicam_xml(client.device(), &bytes);
  EXPECT_EQ(std::string(xml, bytes), genicam_xml(studio.cameras().front()));
  const DeviceRegisters registers(studio.cameras().front());
  const auto url = *registers.read(0x200, 512);
  EXPECT_THAT(std::string(url.begin(), url.end()), testing::StartsWith("Local:rotunda.zip;200000;"));
  EXPECT_FALSE(registers.read(reg::kDescription, bytes / 6));  // a client fetches an eighth or so of the text
}

TEST_F(GigeFeatures, FeaturesThatShareARegisterAgree) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  set_boolean(client, "GevIEEE1588", true);
  AravisError error;
  EXPECT_TRUE(arv_camera_get_boolean(client.camera(), "PtpEnable", error));
  error.check("PtpEnable");
  client.execute("GevTimestampControlLatch");
  EXPECT_GT(client.integer("GevTimestampValue"), 0);
  EXPECT_EQ(client.integer("GevTimestampValue"), client.integer("TimestampLatchValue"));
  EXPECT_EQ(client.integer("WidthMax"), client.integer("SensorWidth"));
}

TEST_F(GigeFeatures, ARegionCropsThePictureAndFollowsItsBounds) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  client.set_integer("Width", 64);
  client.set_integer("Height", 48);
  client.set_integer("OffsetX", 20);
  client.set_integer("OffsetY", 30);
  AravisError error;
  gint64 least = 0, most = 0;
  arv_camera_get_integer_bounds(client.camera(), "OffsetX", &least, &most, error);
  EXPECT_EQ(most, 160 - 64);
  arv_camera_get_integer_bounds(client.camera(), "Width", &least, &most, error);
  EXPECT_EQ(most, 160 - 20);
  EXPECT_EQ(arv_camera_get_integer_increment(client.camera(), "Width", error), 4);
  error.check("bounds");
  EXPECT_THROW(client.set_integer("Width", 62), std::runtime_error);
  client.trigger_by("Software");
  client.start();
  client.execute("TriggerSoftware");
  const auto frame = client.next_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->status, ARV_BUFFER_STATUS_SUCCESS);
  EXPECT_EQ(frame->pixels, read_out(studio.picture(0, frame->exposure_start), 160, 8,
                                    {.width = 64, .height = 48, .offset_x = 20, .offset_y = 30}));
}

TEST_F(GigeFeatures, ChunksParseBesideThePixels) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  client.set_float("ExposureTime", 3210.0);
  client.set_float("Gain", 4.5);
  AravisError error;
  arv_camera_set_chunks(client.camera(), "Timestamp,ExposureTime,LineStatusAll,FrameID,Gain", error);
  error.check("chunks");
  EXPECT_EQ(client.integer("PayloadSize"), static_cast<std::int64_t>(160 * 120 + chunk_data_bytes(160 * 120, 0b11111)));
  client.trigger_by("Software");
  client.start();
  client.execute("TriggerSoftware");
  ArvBuffer* buffer = arv_stream_timeout_pop_buffer(client.stream(), 10'000'000);
  ASSERT_NE(buffer, nullptr);
  EXPECT_EQ(arv_buffer_get_status(buffer), ARV_BUFFER_STATUS_SUCCESS);
  EXPECT_TRUE(arv_buffer_has_chunks(buffer));
  const std::unique_ptr<void, tests::Unreference> parser(arv_camera_create_chunk_parser(client.camera()));
  auto* chunks = ARV_CHUNK_PARSER(parser.get());
  EXPECT_EQ(static_cast<guint64>(arv_chunk_parser_get_integer_value(chunks, buffer, "ChunkTimestamp", error)),
            arv_buffer_get_timestamp(buffer));
  error.check("ChunkTimestamp");
  EXPECT_NEAR(arv_chunk_parser_get_float_value(chunks, buffer, "ChunkExposureTime", error), 3210.0, 1e-6);
  EXPECT_EQ(arv_chunk_parser_get_integer_value(chunks, buffer, "ChunkLineStatusAll", error), 0);
  EXPECT_EQ(arv_chunk_parser_get_integer_value(chunks, buffer, "ChunkFrameID", error), 1);
  EXPECT_NEAR(arv_chunk_parser_get_float_value(chunks, buffer, "ChunkGain", error), 4.5, 1e-6);
  error.check("chunks");
  std::size_t size = 0;
  const auto* pixels = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
  const auto expected = studio.picture(
      0, Timestamp{std::chrono::nanoseconds{static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer))}});
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), pixels));
  arv_stream_push_buffer(client.stream(), buffer);
}

TEST_F(GigeFeatures, ASlowFeatureIsWaitedForByPendingAck) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  client.set_float("ExposureTime", 2000.0);
  client.set("UserSetSelector", "UserSet1");
  const auto before = std::chrono::steady_clock::now();
  client.execute("UserSetSave");  // longer than the 500 ms after which Aravis would ask again
  EXPECT_GE(std::chrono::steady_clock::now() - before, 1200ms);
  EXPECT_EQ(studio.stats()[0].pending_acks, 1U);
  client.set_float("ExposureTime", 4000.0);
  client.execute("UserSetLoad");
  EXPECT_NEAR(client.real("ExposureTime"), 2000.0, 1e-9);
}

TEST_F(GigeFeatures, ExtendedIdsStreamAndResend) {
  TestStudio studio({.cameras = 1, .width = 640, .height = 480});
  (*studio).set_faults({.seed = 3, .packet_loss = {.rate = 0.01}});
  AravisClient client(studio.address(0), kPacketSize);
  client.set("GevGVSPExtendedIDMode", "On");
  client.trigger_by("Software");
  client.start({.frame_retention = 3s});
  for (std::uint64_t block = 1; block <= 8; ++block) {
    client.execute("TriggerSoftware");
    const auto frame = client.next_frame();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->status, ARV_BUFFER_STATUS_SUCCESS);
    EXPECT_EQ(frame->block, block);
    EXPECT_EQ(frame->pixels, studio.picture(0, frame->exposure_start));
  }
  EXPECT_GT(studio.stats()[0].packets_lost, 0U);
  EXPECT_GT(studio.stats()[0].packets_resent, 0U);
}

TEST_F(GigeFeatures, WithPtpOffTheClockIsTheCamerasOwn) {
  TestStudio studio({.cameras = 2, .clock = {.ptp = true, .drift_ppm = 20.0, .wander = 100ns, .seed = 5}});
  AravisClient client(studio.address(1), kPacketSize);
  EXPECT_EQ(client.text("GevIEEE1588Status"), "Slave");
  client.execute("PtpDataSetLatch");
  EXPECT_LE(std::abs(client.integer("PtpOffsetFromMaster")), 100);
  EXPECT_EQ(client.integer("GevIEEE1588OffsetFromMaster"), client.integer("PtpOffsetFromMaster"));
  EXPECT_EQ(AravisClient(studio.address(0)).text("PtpStatus"), "Master");
  set_boolean(client, "PtpEnable", false);
  EXPECT_EQ(client.text("PtpStatus"), "Disabled");
  client.execute("GevTimestampControlReset");
  client.execute("GevTimestampControlLatch");
  const auto latched = client.integer("GevTimestampValue");
  EXPECT_GE(latched, 0);
  EXPECT_LT(latched, 60'000'000'000);
  client.trigger_by("Software");
  client.start();
  client.execute("TriggerSoftware");
  const auto frame = client.next_frame();
  ASSERT_TRUE(frame);
  EXPECT_GE(frame->exposure_start.time_since_epoch().count(), latched);
  EXPECT_LT(frame->exposure_start.time_since_epoch(), 60s);
  set_boolean(client, "GevIEEE1588", true);
  EXPECT_EQ(client.text("PtpStatus"), "Initializing");
}

TEST_F(GigeFeatures, TheTriggerBoxDrivesLine0) {
  TestStudio studio({.cameras = 2, .trigger_box_port = 0});
  std::vector<std::unique_ptr<AravisClient>> clients;
  for (std::size_t i = 0; i < 2; ++i) {
    clients.push_back(std::make_unique<AravisClient>(studio.address(i), kPacketSize));
    clients.back()->trigger_by("Line0");
    clients.back()->start();
  }
  clients[1]->set("TriggerActivation", "FallingEdge");
  UdpSocket box({.address = INADDR_LOOPBACK, .port = 0});
  const Endpoint cameras{.address = INADDR_LOOPBACK, .port = (*studio).trigger_box_port()};
  const Timestamp rise = RigClock::now() + 50ms, fall = rise + 20ms;
  box.send(line_datagram({.high = true, .at = rise}), cameras);
  box.send(line_datagram({.high = false, .at = fall}), cameras);
  const auto first = clients[0]->next_frame(), second = clients[1]->next_frame();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->exposure_start, rise);
  EXPECT_EQ(second->exposure_start, fall);
  box.send(line_datagram({.high = true, .at = {}}), cameras);
  for (int k = 0; k < 500 && clients[0]->integer("LineStatusAll") == 0; ++k) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(clients[0]->integer("LineStatusAll"), 1);
}

TEST_F(GigeFeatures, SelectorsReachTheFeatureTheySelect) {
  TestStudio studio({.cameras = 1});
  AravisClient client(studio.address(0), kPacketSize);
  client.set("BalanceRatioSelector", "Blue");
  client.set_float("BalanceRatio", 1.75);
  client.set("BalanceRatioSelector", "Red");
  EXPECT_NEAR(client.real("BalanceRatio"), 1.0, 1e-9);
  client.set_float("BalanceRatio", 1.25);
  client.set("BalanceRatioSelector", "Blue");
  EXPECT_NEAR(client.real("BalanceRatio"), 1.75, 1e-9);
}

}  // namespace rotunda::simulator
