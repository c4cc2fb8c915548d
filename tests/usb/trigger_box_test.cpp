#include "capture/sync/trigger_box.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <cstdlib>

#include "config/errors.h"
#include "tests/usb/emulated_trigger_box.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using tests::EmulatedTriggerBox;

class PulseLog {
 public:
  TriggerBox::PulseSink sink() {
    return [this](const Pulse& pulse) {
      const std::lock_guard lock(mutex_);
      pulses_.push_back(pulse);
      changed_.notify_all();
    };
  }
  std::vector<Pulse> wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, 20s, [&] { return pulses_.size() >= count; });
    return pulses_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Pulse> pulses_;
};

// The last pulse ends on every line before the train has ended.
bool ends(const TriggerBox& box) {
  for (int i = 0; i < 100 && box.status().running; ++i) std::this_thread::sleep_for(10ms);
  return !box.status().running;
}

std::string told_by(const std::function<void()>& call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST(TriggerBox, GivesACountedTrainWhosePulsesLieOnTheRigsClock) {
  EmulatedTriggerBox device({.serial = "TB0042", .fast_ppm = 80.0});
  PulseLog log;
  TriggerBox box("TB0042", log.sink());
  EXPECT_EQ(box.lines(), 2);
  EXPECT_EQ(box.serial(), "TB0042");
  const auto real = box.set({.period = 20ms, .width = 500us, .count = 10, .delays = {0ns, 3ms}});
  EXPECT_EQ(real.period, 20ms);
  const Timestamp wanted = RigClock::now() + 200ms;
  const Timestamp first = box.start(wanted);
  EXPECT_LT(std::chrono::abs(first - wanted), 1us);
  const auto pulses = log.wait_for(10);
  ASSERT_EQ(pulses.size(), 10U);
  for (std::size_t k = 0; k < pulses.size(); ++k) {
    EXPECT_EQ(pulses[k].number, k);
    // The box's 20 ms are 1.6 us shorter than the rig's; a reading's bracket through the mock is a few hundred us.
    EXPECT_LT(std::chrono::abs(pulses[k].time - (first + static_cast<int>(k) * 20ms)), 5ms);
  }
  EXPECT_EQ(device.pulses(), 10U);
  EXPECT_TRUE(ends(box));
  EXPECT_EQ(box.status().pulses, 10U);
}

TEST(TriggerBox, StopsATrainWithoutAnEnd) {
  EmulatedTriggerBox device;
  PulseLog log;
  TriggerBox box("", log.sink());
  box.set({.period = 10ms});
  box.start(RigClock::now() + 50ms);
  log.wait_for(3);
  EXPECT_TRUE(box.status().running);
  const auto begun = box.stop();
  EXPECT_GE(begun, 3U);
  EXPECT_TRUE(ends(box));
  EXPECT_EQ(device.pulses(), box.status().pulses);
}

TEST(TriggerBox, ATrainLeftBehindIsStoppedByTheNextOwner) {
  EmulatedTriggerBox device;
  {
    TriggerBox box;
    box.set({.period = 10ms});
    box.start(RigClock::now() + 20ms);
  }
  TriggerBox again;
  EXPECT_TRUE(ends(again));
}

TEST(TriggerBox, SaysWhyItWillNot) {
  EmulatedTriggerBox device;
  TriggerBox box;
  EXPECT_NE(told_by([&] { box.set({.period = 1us}); }).find("out of its range"), std::string::npos);
  box.set({.period = 10ms, .width = 9ms, .delays = {2ms}});
  EXPECT_NE(told_by([&] { box.start(RigClock::now() + 100ms); }).find("shorter than the period"), std::string::npos);
  box.set({.period = 10ms});
  EXPECT_NE(told_by([&] { box.start(RigClock::now() - 1s); }).find("had passed"), std::string::npos);
  EXPECT_NE(told_by([&] { box.set({.delays = {0ns, 0ns, 0ns}}); }).find("2 lines"), std::string::npos);
}

TEST(TriggerBox, IsFoundBySerialNumber) {
  EXPECT_TRUE(find_trigger_boxes().empty());
  EXPECT_NE(told_by([] { TriggerBox box; }).find("none on USB"), std::string::npos);
  EmulatedTriggerBox device({.serial = "TB0007"});
  const auto found = find_trigger_boxes();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].serial, "TB0007");
  EXPECT_NE(told_by([] { TriggerBox box("TB0008"); }).find("TB0007"), std::string::npos);
}

TEST(TriggerBox, IsLostWhenUnpluggedAndThereAgainWhenBack) {
  {
    EmulatedTriggerBox device;
    TriggerBox box;
    box.set({.period = 10ms});
    box.start(RigClock::now() + 50ms);
    device.unplug();
    for (int i = 0; i < 200 && !box.lost(); ++i) std::this_thread::sleep_for(10ms);
    EXPECT_TRUE(box.lost());
    EXPECT_TRUE(box.status().lost);
    EXPECT_NE(told_by([&] { box.stop(); }).find("lost"), std::string::npos);
  }
  EmulatedTriggerBox back;
  TriggerBox box;
  EXPECT_FALSE(box.lost());
}

TEST(TriggerBox, TellsOfABoxThatDoesNotAnswer) {
  EmulatedTriggerBox device;
  TriggerBox box;
  device.stop_answering();
  EXPECT_NE(told_by([&] { box.stop(); }).find("does not answer"), std::string::npos);
}

}  // namespace
}  // namespace rotunda::capture
