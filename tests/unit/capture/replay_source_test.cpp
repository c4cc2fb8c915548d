#include "capture/source/replay_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <mutex>

#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "tests/unit/capture/take_fixture.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using namespace test;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kRate = 50.0;
constexpr auto kPeriod = 20ms;

// Four frame sets of two cameras; camera 1 lacks the third.
class ReplaySourceTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto cameras = cameras_of(2);
    TakeWriter writer(options_for(folder(), cameras));
    for (std::uint64_t trigger = 10; trigger < 14; ++trigger) {
      auto set = frame_set(cameras, trigger);
      if (trigger == 12) set.slots[1] = {.frame = std::nullopt, .missing_because = HoleReason::late};
      writer.write(set);
    }
    writer.finish();
  }

  std::filesystem::path folder() const { return root_.path() / "walk"; }
  SourceSettings settings(const CameraId& camera, TriggerMode trigger = TriggerMode::freerun) const {
    return {
        .camera = camera, .kind = "replay", .device = folder().string(), .frame_rate_hz = kRate, .trigger = trigger};
  }
  // So many frames of it.
  static std::vector<Frame> frames_of(Source& source, std::size_t count) {
    std::mutex mutex;
    std::vector<Frame> frames;
    std::promise<void> enough;
    source.start(
        [&](Frame&& frame) {
          const std::lock_guard lock(mutex);
          frames.push_back(std::move(frame));
          if (frames.size() == count) enough.set_value();
        },
        {});
    EXPECT_EQ(enough.get_future().wait_for(10s), std::future_status::ready);
    source.stop();
    return frames;
  }

  TemporaryFolder root_;
};

TEST_F(ReplaySourceTest, SendsTheTakeOverAndOverOnTheRigsGrid) {
  const auto source = make_source(settings("cam00"));
  source->open();
  source->arm();
  EXPECT_EQ(source->description().width, 64);
  const auto frames = frames_of(*source, 6);
  const TakeReader take(folder());
  for (const auto& frame : frames) {
    const auto since = frame.exposure_start.time_since_epoch();
    EXPECT_EQ(since % kPeriod, 0ns) << "the first camera exposed at its trigger";
    const auto index = static_cast<std::size_t>(since / kPeriod % 4);
    const auto recorded = take.read(index, 0);
    EXPECT_TRUE(std::ranges::equal(frame.image.bytes(), recorded.frame->image.bytes()));
    EXPECT_EQ(frame.exposure, recorded.frame->exposure);
  }
  EXPECT_EQ(source->stats().frames >= 6, true);
}

TEST_F(ReplaySourceTest, CamerasStayTogetherAndAHoleStaysOne) {
  const auto source = make_source(settings("cam01"));
  source->open();
  source->arm();
  for (const auto& frame : frames_of(*source, 5)) {
    const auto since = (frame.exposure_start - 1ns).time_since_epoch();  // as it was recorded, behind camera 0
    EXPECT_EQ(since % kPeriod, 0ns);
    EXPECT_NE(since / kPeriod % 4, 2) << "the take has no such frame";
  }
}

TEST_F(ReplaySourceTest, ASoftwareTriggerSendsTheNextFrame) {
  const auto source = make_source(settings("cam00", TriggerMode::software));
  source->open();
  source->arm();
  std::mutex mutex;
  std::vector<std::uint64_t> ids;
  source->start(
      [&](Frame&& frame) {
        const std::lock_guard lock(mutex);
        ids.push_back(*frame.id);
      },
      {});
  for (int i = 0; i < 3; ++i) source->software_trigger();
  for (int i = 0; i < 500 && source->stats().frames < 3; ++i) std::this_thread::sleep_for(10ms);
  source->stop();
  EXPECT_THAT(ids, testing::ElementsAre(1u, 2u, 3u));
}

TEST_F(ReplaySourceTest, RefusesWhatItCannotDoInWords) {
  EXPECT_THAT([&] { make_source(settings("cam07"))->open(); },
              ThrowsMessage<DeviceError>(HasSubstr("no camera of this")));
  auto elsewhere = settings("cam00");
  elsewhere.device = (root_.path() / "nowhere").string();
  EXPECT_THAT([&] { make_source(elsewhere)->open(); }, ThrowsMessage<DeviceError>(HasSubstr("cannot be replayed")));
  const auto source = make_source(settings("cam00", TriggerMode::action));
  source->open();
  EXPECT_THAT([&] { source->arm(); }, ThrowsMessage<DeviceError>(HasSubstr("freerun or software")));
  auto larger = settings("cam00");
  larger.width = 65;
  const auto wrong = make_source(larger);
  wrong->open();
  EXPECT_THAT([&] { wrong->arm(); }, ThrowsMessage<DeviceError>(HasSubstr("64 x 48")));
}

TEST_F(ReplaySourceTest, CanBeOpenedAgain) {
  const auto source = make_source(settings("cam00"));
  for (int round = 0; round < 2; ++round) {
    source->open();
    source->arm();
    EXPECT_EQ(source->state(), SourceState::armed);
    EXPECT_GE(frames_of(*source, 1).size(), 1u);
    source->close();
    EXPECT_EQ(source->state(), SourceState::closed);
  }
}

}  // namespace
}  // namespace rotunda::capture
