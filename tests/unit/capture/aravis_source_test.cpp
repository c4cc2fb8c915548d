// The Aravis source against Aravis' own fake camera: a GigE Vision peer that none of us wrote.
#include "capture/source/aravis_source.h"

#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/base/bounded_queue.h"
#include "capture/source/aravis_handle.h"
#include "capture/source/stream_socket.h"
#include "config/errors.h"
#include "tests/support/device_error.h"
#include "tests/support/private_network.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using tests::device_error_of;

class AravisSourceTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto why_not = tests::enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
    fake_.reset(arv_gv_fake_camera_new("127.0.0.1", "GV01"));
    ASSERT_TRUE(arv_gv_fake_camera_is_running(fake_.get()));
  }

  static SourceSettings settings() {
    SourceSettings settings;
    settings.camera = "cam00";
    settings.device = "127.0.0.1";
    settings.width = 160;
    settings.height = 120;
    settings.format = PixelFormat::mono8;
    settings.exposure_us = 4000;
    settings.frame_rate_hz = 20;
    return settings;
  }

  FrameSink into_queue() {
    return [this](Frame&& frame) { queue_.try_push(std::move(frame)); };
  }

  GRef<ArvGvFakeCamera> fake_;
  BoundedQueue<Frame> queue_{100};
};

TEST_F(AravisSourceTest, StreamsWholeFramesAndDescribesTheCamera) {
  const auto source = make_source(settings());
  source->open();
  source->arm();
  EXPECT_EQ(source->state(), SourceState::armed);
  const auto description = source->description();
  EXPECT_EQ(description.vendor, "Aravis");
  EXPECT_EQ(description.serial, "GV01");
  EXPECT_EQ(description.address, "127.0.0.1");
  EXPECT_EQ(description.width, 160);
  EXPECT_EQ(description.height, 120);
  EXPECT_EQ(description.format, PixelFormat::mono8);
  EXPECT_EQ(description.exposure, 4ms);
  source->start(into_queue());
  EXPECT_EQ(source->state(), SourceState::streaming);
  Timestamp last{};
  for (int i = 0; i < 4; ++i) {
    const auto frame = queue_.wait_pop(10s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->camera, "cam00");
    EXPECT_EQ(frame->image.bytes().size(), 160u * 120u);
    EXPECT_EQ(frame->exposure, 4ms);
    EXPECT_GT(frame->exposure_start, last);
    last = frame->exposure_start;
  }
  source->stop();
  EXPECT_EQ(source->stats().incomplete, 0u);
  EXPECT_GE(source->stats().frames, 4u);
  source->close();
  EXPECT_EQ(source->state(), SourceState::closed);
}

TEST_F(AravisSourceTest, PreparesTheSocketBeforeTheFirstPacketAndSaysHowMuchItGot) {
  const auto source = make_source(settings());
  source->open();
  source->arm();
  const auto stats = source->stats();
  EXPECT_GT(stats.socket_buffer_bytes, 0);
  EXPECT_EQ(stats.socket_buffer_bytes < wanted_socket_buffer_bytes, !source->description().warnings.empty());
  EXPECT_EQ(stats.packet_size, 8900) << "loopback carries jumbo packets";
  EXPECT_FALSE(stats.packet_socket) << "which gain nothing from a packet socket";
}

TEST_F(AravisSourceTest, PixelsOutliveTheSourceInTheHandsOfTheirReaders) {
  const auto source = make_source(settings());
  source->open();
  source->arm();
  source->start(into_queue());
  std::vector<Frame> held;
  for (int i = 0; i < 3; ++i) held.push_back(queue_.wait_pop(10s).value());
  source->close();
  for (const Frame& frame : held) EXPECT_EQ(frame.image.bytes().back(), frame.image.bytes().back());
}

TEST_F(AravisSourceTest, KeepsStreamingWhileReadersHoldMoreFramesThanWereReady) {
  auto few = settings();
  few.buffers = 2;
  few.buffers_at_most = 20;
  const auto source = make_source(few);
  source->open();
  source->arm();
  source->start(into_queue());
  std::vector<Frame> held;
  for (int i = 0; i < 8; ++i) {
    auto frame = queue_.wait_pop(10s);
    ASSERT_TRUE(frame) << "starved after " << i;
    held.push_back(std::move(*frame));
  }
  EXPECT_EQ(source->stats().underruns, 0u);
}

TEST_F(AravisSourceTest, FiresOneFrameForEachSoftwareTrigger) {
  auto triggered = settings();
  triggered.trigger = TriggerMode::software;
  const auto source = make_source(triggered);
  source->open();
  source->arm();
  source->start(into_queue());
  for (int i = 0; i < 3; ++i) {
    source->software_trigger();
    EXPECT_TRUE(queue_.wait_pop(10s)) << "trigger " << i;
  }
  EXPECT_FALSE(queue_.wait_pop(200ms)) << "a frame nobody asked for";
}

TEST_F(AravisSourceTest, CanBeStoppedStartedAndOpenedAgain) {
  const auto source = make_source(settings());
  for (int round = 0; round < 2; ++round) {
    source->open();
    source->arm();
    for (int turn = 0; turn < 2; ++turn) {
      source->start(into_queue());
      EXPECT_TRUE(queue_.wait_pop(10s));
      source->stop();
      while (queue_.size() > 0) queue_.pop();
      EXPECT_FALSE(queue_.wait_pop(150ms)) << "a sink was called after stop";
    }
    source->close();
  }
}

TEST_F(AravisSourceTest, RefusesCallsInTheWrongState) {
  const auto source = make_source(settings());
  EXPECT_THROW(source->arm(), InvalidInput);
  EXPECT_THROW(source->start(into_queue()), InvalidInput);
  EXPECT_THROW(source->stop(), InvalidInput);
  EXPECT_THROW(source->software_trigger(), InvalidInput);
  source->close();
  source->open();
  EXPECT_THROW(source->open(), InvalidInput);
  EXPECT_THROW(source->start(into_queue()), InvalidInput);
  source->arm();
  EXPECT_THROW(source->arm(), InvalidInput);
  EXPECT_THROW(source->stop(), InvalidInput);
  EXPECT_THROW(source->software_trigger(), InvalidInput);
}

TEST_F(AravisSourceTest, NamesTheCameraWhatItAnsweredAndWhatToDoAboutAWrongSize) {
  auto wrong = settings();
  wrong.width = 100000;
  const auto source = make_source(wrong);
  source->open();
  const auto message = device_error_of([&] { source->arm(); });
  EXPECT_THAT(message, testing::AllOf(HasSubstr("cam00"), HasSubstr("100000 x 120"), HasSubstr("set width")));
  EXPECT_EQ(source->state(), SourceState::open);
}

TEST_F(AravisSourceTest, SaysThatACameraKnowsNoActionCommands) {
  auto wrong = settings();
  wrong.trigger = TriggerMode::action;
  const auto source = make_source(wrong);
  source->open();
  EXPECT_THAT(device_error_of([&] { source->arm(); }),
              testing::AllOf(HasSubstr("cam00"), HasSubstr("Action"), HasSubstr("software")));
}

TEST_F(AravisSourceTest, RefusesPacketsThatDoNotFitTheLink) {
  auto wrong = settings();
  wrong.packet_size = 70000;
  const auto source = make_source(wrong);
  source->open();
  EXPECT_THAT(device_error_of([&] { source->arm(); }),
              testing::AllOf(HasSubstr("70000"), HasSubstr("65536"), HasSubstr("packet_size")));
}

TEST_F(AravisSourceTest, UsesAPacketSocketForSmallPacketsWhereAllowed) {
  auto small = settings();
  small.packet_size = 1400;
  const auto source = make_source(small);
  source->open();
  source->arm();
  EXPECT_EQ(source->stats().packet_size, 1400);
  EXPECT_EQ(source->stats().packet_socket, may_open_packet_socket());
  source->start(into_queue());
  EXPECT_TRUE(queue_.wait_pop(10s));
}

TEST_F(AravisSourceTest, SaysThatNobodyAnswers) {
  auto absent = settings();
  absent.device = "127.0.0.200";
  const auto source = make_source(absent);
  EXPECT_THAT(device_error_of([&] { source->open(); }), testing::AllOf(HasSubstr("cam00"), HasSubstr("127.0.0.200")));
  EXPECT_EQ(source->state(), SourceState::closed);
}

TEST_F(AravisSourceTest, DiscoversTheCamera) {
  const auto cameras = discover_cameras();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].kind, "aravis");
  EXPECT_EQ(cameras[0].address, "127.0.0.1");
  EXPECT_EQ(cameras[0].serial, "GV01");
  EXPECT_EQ(cameras[0].vendor, "Aravis");
}

}  // namespace
}  // namespace rotunda::capture
