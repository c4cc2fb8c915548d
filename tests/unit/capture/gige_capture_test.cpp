// The capture chain against the simulated GigE Vision cameras: sources, action triggers, frame sets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/source/source.h"
#include "capture/sync/action_command.h"
#include "capture/sync/frame_set_assembler.h"
#include "capture/sync/trigger.h"
#include "config/errors.h"
#include "tests/support/device_error.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using tests::device_error_of;

constexpr double rate_hz = 5;  // slow enough for a loaded machine under the sanitizers
constexpr std::uint32_t device_key = 0x52544441, group_key = 1, group_mask = 1;

SourceSettings settings_of(const simulator::GigeCameraOptions& camera) {
  SourceSettings settings;
  settings.camera = camera.name;
  settings.device = camera.address;
  settings.width = camera.width;
  settings.height = camera.height;
  settings.format = camera.format;
  settings.exposure_us = 5000;
  settings.frame_rate_hz = rate_hz;
  settings.trigger = TriggerMode::action;
  settings.device_key = device_key;
  settings.group_key = group_key;
  settings.group_mask = group_mask;
  return settings;
}

// Cameras brought to streaming into one queue, triggered together, assembled.
class Rig {
 public:
  explicit Rig(const std::vector<SourceSettings>& cameras) {
    for (const auto& settings : cameras) {
      names_.push_back(settings.camera);
      sources_.push_back(make_source(settings));
      sources_.back()->open();
      sources_.back()->arm();
    }
    for (auto& source : sources_) source->start([this](Frame&& frame) { frames_.push_drop_oldest(std::move(frame)); });
  }

  // Triggers `count` times and returns the sets of all of them, the last waited for long past its moment.
  std::vector<FrameSet> take(std::uint64_t count) {
    const auto options = scheduled_triggers(rate_hz, count, RigClock::now());
    grid = options.grid;
    FrameSetAssembler assembler({names_, grid, count, 10s, std::nullopt});
    TriggerSchedule schedule(options, [this](const Trigger& trigger) {
      sender.send({device_key, group_key, group_mask, trigger.at});
    });
    std::vector<FrameSet> sets;
    const auto keep = [&](std::vector<FrameSet> more) {
      for (auto& set : more) sets.push_back(std::move(set));
    };
    while (!assembler.done()) {
      auto frame = frames_.wait_pop(100ms);
      const Timestamp now = RigClock::now();
      keep(frame ? assembler.add(std::move(*frame), now) : assembler.advance(now));
    }
    schedule.wait();
    triggers = schedule.counts();
    counts = assembler.counts();
    sender.collect_acks(1s, names_.size());
    return sets;
  }

  Source& source(std::size_t camera) { return *sources_[camera]; }

  TriggerGrid grid;
  TriggerCounts triggers;
  AssemblerCounts counts;
  ActionCommandSender sender{{.interface_address = "127.0.0.1"}};

 private:
  BoundedQueue<Frame> frames_{1000};
  std::vector<CameraId> names_;
  std::vector<std::unique_ptr<Source>> sources_;  // last: their threads fill the queue
};

std::vector<SourceSettings> settings_of_all(const tests::TestStudio& studio) {
  std::vector<SourceSettings> all;
  for (const auto& camera : studio.cameras()) all.push_back(settings_of(camera));
  return all;
}

class GigeCaptureTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto why_not = tests::enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
  }
};

TEST_F(GigeCaptureTest, FiveScheduledTriggersOfTenCamerasAreFiveCompleteSetsExactlyOnTheSchedule) {
  const tests::TestStudio studio({.cameras = 10});
  Rig rig(settings_of_all(studio));
  const auto sets = rig.take(5);
  ASSERT_EQ(sets.size(), 5u);
  EXPECT_EQ(rig.triggers.fired, 5u);
  for (const FrameSet& set : sets) {
    EXPECT_TRUE(set.complete()) << "trigger " << set.trigger;
    for (std::size_t c = 0; c < set.slots.size(); ++c) {
      const auto& frame = set.slots[c].frame;
      if (!frame) continue;
      EXPECT_EQ(frame->exposure_start, rig.grid.time_of(set.trigger));
      EXPECT_EQ(frame->exposure, 5ms);
      const auto truth = studio.picture(c, frame->exposure_start);
      const auto pixels = frame->image.bytes();
      EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), truth.begin(), truth.end())) << frame->camera;
    }
  }
  EXPECT_EQ(rig.counts.complete, 5u);
  const auto acks = rig.sender.acks();
  EXPECT_EQ(acks.size(), 10u);
  for (const auto& [address, count] : acks) EXPECT_EQ(count.accepted + count.late, 5u) << address;
}

TEST_F(GigeCaptureTest, ResendsMakeEveryFrameWholeWhenOnePacketInAHundredIsLost) {
  tests::TestStudio studio({.cameras = 2, .width = 320, .height = 240});
  (*studio).set_faults({.seed = 7, .packet_loss = {.rate = 0.01}});
  auto settings = settings_of_all(studio);
  for (auto& camera : settings) camera.packet_size = 600;  // some 140 packets a frame
  Rig rig(settings);
  const auto sets = rig.take(8);
  std::uint64_t lost = 0, resent = 0, requests = 0;
  for (const auto& stats : studio.stats()) {
    lost += stats.packets_lost;
    resent += stats.packets_resent;
  }
  for (std::size_t c = 0; c < 2; ++c) {
    requests += rig.source(c).stats().resend_requests;
    EXPECT_EQ(rig.source(c).stats().incomplete, 0u);
  }
  EXPECT_EQ(rig.counts.complete, 8u);
  EXPECT_GT(lost, 0u);
  EXPECT_GT(resent, 0u);
  EXPECT_GT(requests, 0u);
}

TEST_F(GigeCaptureTest, AFrameThatLostPacketsForGoodIsToldWithItsTime) {
  tests::TestStudio studio({.cameras = 1, .width = 320, .height = 240});
  auto settings = settings_of_all(studio);
  settings[0].packet_size = 600;
  settings[0].trigger = TriggerMode::software;
  const auto source = make_source(settings[0]);
  source->open();
  source->arm();
  BoundedQueue<IncompleteFrame> incomplete(10);
  source->start([](Frame&&) {}, [&](const IncompleteFrame& frame) { incomplete.try_push(frame); });
  (*studio).set_faults({.seed = 3, .packet_loss = {.rate = 0.9}});
  for (int i = 0; i < 4; ++i) {
    source->software_trigger();
    std::this_thread::sleep_for(250ms);
  }
  const auto frame = incomplete.wait_pop(10s);
  ASSERT_TRUE(frame) << "frames " << source->stats().frames << ", incomplete " << source->stats().incomplete
                     << ", resend requests " << source->stats().resend_requests << ", missing packets "
                     << source->stats().missing_packets;
  EXPECT_EQ(frame->camera, "cam00");
  if (frame->exposure_start) {
    EXPECT_LT(std::chrono::abs(RigClock::now() - *frame->exposure_start), 60s);
  }
  EXPECT_GT(source->stats().incomplete, 0u);
}

// One leader with a block id too high, and Aravis takes the frames after it for late ones.
TEST_F(GigeCaptureTest, AStreamThatHearsNoFramesAnyMoreIsMadeAnew) {
  tests::TestStudio studio({.cameras = 1});
  auto settings = settings_of_all(studio)[0];
  settings.trigger = TriggerMode::software;
  const auto source = make_source(settings);
  source->open();
  source->arm();
  BoundedQueue<Frame> frames(100);
  source->start([&](Frame&& frame) { frames.push_drop_oldest(std::move(frame)); });
  source->software_trigger();
  ASSERT_TRUE(frames.wait_pop(10s));
  (*studio).set_faults({.corrupted_leader = {.flaw = simulator::LeaderFlaw::block_id, .rate = 1.0}});
  source->software_trigger();
  EXPECT_FALSE(frames.wait_pop(1s));
  EXPECT_FALSE(source->heal()) << "one frame is lost, no more";
  (*studio).set_faults({});
  std::optional<std::string> ailment;
  for (int i = 0; i < 20 && !ailment; ++i) {
    source->software_trigger();
    EXPECT_FALSE(frames.wait_pop(300ms)) << "then there is nothing to cure";
    ailment = source->heal();
  }
  ASSERT_TRUE(ailment);
  EXPECT_THAT(*ailment, testing::AllOf(HasSubstr("cam00"), HasSubstr("block ids"), HasSubstr("made anew")));
  for (int i = 0; i < 3; ++i) {
    source->software_trigger();
    EXPECT_TRUE(frames.wait_pop(10s)) << "frame " << i << " after the cure";
    EXPECT_FALSE(source->heal());
  }
  EXPECT_EQ(source->state(), SourceState::streaming);
}

TEST_F(GigeCaptureTest, SettingsByPlainNameAndByTheirOwnReachTheCameraAndDifferencesAreTold) {
  const tests::TestStudio studio({.cameras = 1, .width = 160, .height = 120});
  auto settings = settings_of_all(studio)[0];
  settings.trigger = TriggerMode::software;
  settings.user_set = "Default";
  settings.width = 80;
  settings.height = 60;
  settings.offset_x = 40;
  settings.offset_y = 10;
  settings.white_balance = WhiteBalance{.auto_once = false, .red = 1.5, .blue = 2.0};
  settings.features = {{"LineDebounceTime", "12"}, {"GevHeartbeatTimeout", "4000"}};
  const auto source = make_source(settings);
  source->open();
  source->arm();
  EXPECT_THAT(source->description().warnings, testing::Each(HasSubstr("socket buffer"))) << "it took all as asked";
  BoundedQueue<Frame> frames(10);
  source->start([&](Frame&& frame) { frames.try_push(std::move(frame)); });
  source->software_trigger();
  const auto frame = frames.wait_pop(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.width, 80);
  EXPECT_EQ(frame->image.height, 60);
  source->close();
  settings.features = {{"NoSuchFeature", "1"}};
  const auto wrong = make_source(settings);
  wrong->open();
  EXPECT_THAT(device_error_of([&] { wrong->arm(); }), testing::AllOf(HasSubstr("cam00"), HasSubstr("NoSuchFeature")));
}

TEST_F(GigeCaptureTest, ACameraIsPacedWhileItIsArmedOnly) {
  const tests::TestStudio studio({.cameras = 1});
  auto settings = settings_of_all(studio)[0];
  settings.trigger = TriggerMode::software;
  const auto source = make_source(settings);
  source->open();
  source->arm();
  EXPECT_EQ(source->description().link, "lo");
  EXPECT_EQ(source->description().link_bits_per_second, 0.0) << "loopback has no limit";
  source->pace({.packet_delay = 20us, .start_delay = 100ms});
  BoundedQueue<Frame> frames(10);
  source->start([&](Frame&& frame) { frames.try_push(std::move(frame)); });
  EXPECT_THROW(source->pace({}), InvalidInput);
  source->software_trigger();
  const auto frame = frames.wait_pop(10s);
  ASSERT_TRUE(frame);
  EXPECT_GE(RigClock::now() - frame->exposure_start, 105ms) << "exposed for 5 ms, then held back for 100 ms";
}

TEST_F(GigeCaptureTest, PtpCamerasTellTheirClockAndTemperature) {
  const tests::TestStudio studio({.cameras = 2, .clock = {.ptp = true, .drift_ppm = 20.0, .wander = 100ns, .seed = 5}});
  Rig rig(settings_of_all(studio));
  std::vector<NamedClock> clocks;
  for (std::size_t c = 0; c < 2; ++c) {
    const auto health = rig.source(c).look();
    EXPECT_EQ(health.clock.kind, c == 0 ? "ptp master" : "ptp slave");
    EXPECT_TRUE(health.clock.settled);
    EXPECT_EQ(health.clock.problem, "");
    ASSERT_TRUE(health.temperature_c);
    EXPECT_NEAR(*health.temperature_c, 45.0, 25.0);
    clocks.push_back({rig.source(c).description().serial, health.clock});
  }
  EXPECT_LE(*clocks[1].clock.error, 300ns) << "wanders by 100 ns";
  EXPECT_THAT(ptp_domain_problems(clocks), testing::IsEmpty());
}

TEST_F(GigeCaptureTest, ACameraWithoutPtpHasItsTimeStampsMovedToTheRigsClock) {
  const tests::TestStudio studio({.cameras = 1, .clock = {.ptp = false, .drift_ppm = 40.0}});
  auto settings = settings_of_all(studio)[0];
  settings.trigger = TriggerMode::software;
  settings.clock.use_ptp = false;
  const auto source = make_source(settings);
  source->open();
  source->arm();
  BoundedQueue<Frame> frames(10);
  source->start([&](Frame&& frame) { frames.try_push(std::move(frame)); });
  const auto health = source->look();
  EXPECT_EQ(health.clock.kind, "model");
  ASSERT_TRUE(health.clock.error);
  const Timestamp asked = RigClock::now();
  source->software_trigger();
  const auto frame = frames.wait_pop(10s);
  ASSERT_TRUE(frame);
  EXPECT_GE(frame->exposure_start, asked - *health.clock.error - 1ms);
  EXPECT_LE(frame->exposure_start, RigClock::now());
}

TEST_F(GigeCaptureTest, ACameraThatIsControlledBySomebodyElseIsRefusedByName) {
  const tests::TestStudio studio({.cameras = 1});
  const auto first = make_source(settings_of_all(studio)[0]);
  first->open();
  const auto second = make_source(settings_of_all(studio)[0]);
  EXPECT_THAT(device_error_of([&] {
                second->open();
                second->arm();
              }),
              testing::AllOf(HasSubstr("cam00"), HasSubstr("controlled by another program")));
  EXPECT_NO_THROW(first->arm()) << "the first keeps it";
}

TEST_F(GigeCaptureTest, AWrongPixelFormatIsRefusedWithThoseThatWouldDo) {
  const tests::TestStudio studio({.cameras = 1, .format = PixelFormat::bayer_rg8});
  auto settings = settings_of_all(studio)[0];
  settings.format = PixelFormat::rgb8;
  const auto source = make_source(settings);
  source->open();
  EXPECT_THAT(device_error_of([&] { source->arm(); }),
              testing::AllOf(HasSubstr("cam00"), HasSubstr("RGB8"), HasSubstr("pixel_format"), HasSubstr("BayerRG8")));
  EXPECT_EQ(source->state(), SourceState::open);
}

TEST_F(GigeCaptureTest, OpensBySerialNumberUserNameAndMac) {
  const tests::TestStudio studio({.cameras = 3});
  for (const char* device : {"RS0002", "cam02", "02:52:54:00:00:03"}) {
    auto settings = settings_of_all(studio)[2];
    settings.device = device;
    const auto source = make_source(settings);
    source->open();
    source->arm();
    EXPECT_EQ(source->description().address, studio.address(2)) << device;
  }
}

TEST_F(GigeCaptureTest, DiscoversEveryCameraOnce) {
  const tests::TestStudio studio({.cameras = 10});
  const auto cameras = discover_cameras();
  ASSERT_EQ(cameras.size(), 10u);
  for (const auto& camera : cameras) {
    const auto number = camera.serial.substr(4);  // "RS00nn"
    EXPECT_EQ(camera.user_name, "cam" + number) << camera.address;
    EXPECT_EQ(camera.address, studio.address(static_cast<std::size_t>(std::stoi(number))));
    EXPECT_FALSE(camera.mac.empty());
  }
}

TEST_F(GigeCaptureTest, ASilentCameraIsNoticedFirstByItsHolesThenByItsState) {
  tests::TestStudio studio({.cameras = 2});
  Rig rig(settings_of_all(studio));
  (*studio).set_faults(1, {.silent = true});
  const Timestamp silenced = RigClock::now();
  FrameSetAssembler assembler({{"cam00", "cam01"}, grid_from(silenced, 200ms), 3, 100ms, std::nullopt});
  assembler.advance(silenced + 2s);
  EXPECT_EQ(assembler.counts().cameras[1].missing_in_a_row, 3u);
  for (int i = 0; i < 200 && rig.source(1).state() != SourceState::lost; ++i) std::this_thread::sleep_for(100ms);
  EXPECT_EQ(rig.source(1).state(), SourceState::lost);
  EXPECT_EQ(rig.source(0).state(), SourceState::streaming);
  EXPECT_THAT(device_error_of([&] { rig.source(1).stop(); }), testing::AllOf(HasSubstr("cam01"), HasSubstr("lost")));
  (*studio).set_faults(1, {});
  rig.source(1).close();
  EXPECT_NO_THROW(rig.source(1).open()) << "a camera that is back can be opened anew";
}

}  // namespace
}  // namespace rotunda::capture
