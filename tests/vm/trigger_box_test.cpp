// The trigger box over a real USB stack: libusb, the kernel's usbfs and hub driver, and on the other end of its dummy
// host controller the firmware's state machine. Pulses and the box's own times are asserted, never this machine's
// speed.
#include "capture/sync/trigger_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <mutex>

#include "config/errors.h"
#include "tests/vm/trigger_box_gadget.h"

namespace rotunda::vm {
namespace {

using namespace std::chrono_literals;
using capture::RigClock;
using capture::TriggerBox;

// An emulated processor takes a while to enumerate a device.
bool soon(const std::function<bool()>& is_so) {
  for (int i = 0; i < 600; ++i) {
    if (is_so()) return true;
    std::this_thread::sleep_for(50ms);
  }
  return false;
}

bool listed(const std::string& serial) {
  for (const auto& box : capture::find_trigger_boxes())
    if (box.serial == serial) return true;
  return false;
}

class PulseLog {
 public:
  TriggerBox::PulseSink sink() {
    return [this](const capture::Pulse& pulse) {
      const std::lock_guard lock(mutex_);
      pulses_.push_back(pulse);
    };
  }
  std::vector<capture::Pulse> pulses() const {
    const std::lock_guard lock(mutex_);
    return pulses_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<capture::Pulse> pulses_;
};

class UsbTriggerBox : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(soon([&] { return listed("TB0042"); })) << "the kernel never listed the box";
  }

  // The edges of one line since the train began.
  std::vector<LineEdge> edges_of(unsigned line) const {
    auto edges = gadget.edges();
    std::erase_if(edges, [&](const LineEdge& edge) { return edge.line != line; });
    return edges;
  }

  TriggerBoxGadget gadget{"TB0042"};
};

TEST_F(UsbTriggerBox, IsFoundOnItsPortBySerialNumberAndSaysHello) {
  const auto found = capture::find_trigger_boxes();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].port, testing::MatchesRegex("[0-9]+-1"));  // the dummy controller has one port
  const TriggerBox box("TB0042");
  EXPECT_EQ(box.lines(), 2);
  EXPECT_THAT([] { TriggerBox other("TB0043"); }, testing::ThrowsMessage<DeviceError>(testing::HasSubstr("TB0042")));
}

TEST_F(UsbTriggerBox, RateWidthCountAndEachLinesDelayAreOnTheLines) {
  PulseLog log;
  TriggerBox box("TB0042", log.sink());
  constexpr auto period = 60ms, width = 7ms;
  const std::vector<std::chrono::nanoseconds> delays{2ms, 11ms};
  const auto real = box.set({.period = period, .width = width, .count = 12, .delays = delays});
  EXPECT_EQ(real.period, period);
  EXPECT_EQ(real.width, width);
  EXPECT_EQ(real.delays, delays);
  const auto first = box.start(RigClock::now() + 3s);
  ASSERT_TRUE(soon([&] { return log.pulses().size() == 12 && !box.status().running; }));
  EXPECT_EQ(gadget.pulses(), 12U);
  EXPECT_EQ(box.status().pulses, 12U);
  EXPECT_EQ(box.status().events_lost, 0U);
  const auto pulses = log.pulses();
  for (std::size_t k = 0; k < pulses.size(); ++k) EXPECT_EQ(pulses[k].number, k);
  // On the rig's clock through the fitted model; how well depends on this machine, a wrong pulse would be 60 ms off.
  EXPECT_LT(std::chrono::abs(pulses[11].time - (first + 11 * period)), period / 2);
  for (unsigned line = 0; line < 2; ++line) {
    const auto edges = edges_of(line);
    ASSERT_EQ(edges.size(), 24U);
    for (std::size_t k = 0; k < 12; ++k) {
      const auto rise = edges[2 * k].at - edges_of(0)[0].at, fall = edges[2 * k + 1].at - edges_of(0)[0].at;
      EXPECT_TRUE(edges[2 * k].high && !edges[2 * k + 1].high);
      const std::chrono::nanoseconds wanted = static_cast<int>(k) * period + (delays[line] - delays[0]);
      EXPECT_EQ(rise, static_cast<std::uint64_t>(wanted.count()));
      EXPECT_EQ(fall - rise, static_cast<std::uint64_t>(std::chrono::nanoseconds(width).count()));
    }
  }
}

TEST_F(UsbTriggerBox, ATrainWithoutAnEndIsStoppedWithTheSameCountOnBothSides) {
  PulseLog log;
  TriggerBox box("TB0042", log.sink());
  box.set({.period = 40ms});
  box.start(RigClock::now() + 2s);
  ASSERT_TRUE(soon([&] { return log.pulses().size() >= 4; }));
  const auto told = box.stop();
  EXPECT_GE(told, 4U);
  ASSERT_TRUE(soon([&] { return !gadget.pulsing() && !box.status().running; }));
  EXPECT_EQ(gadget.pulses(), told);
  const auto edges = edges_of(0);
  EXPECT_EQ(edges.size(), 2 * told) << "the pulse under way has ended as it should";
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(gadget.pulses(), told);
}

TEST_F(UsbTriggerBox, RefusesInWordsWhatItCannotDo) {
  TriggerBox box("TB0042");
  EXPECT_THAT([&] { box.set({.period = 1us}); },
              testing::ThrowsMessage<DeviceError>(testing::HasSubstr("out of its range")));
  box.set({.period = 10ms});
  EXPECT_THAT([&] { box.start(RigClock::now() - 10s); },
              testing::ThrowsMessage<DeviceError>(testing::HasSubstr("had passed")));
  EXPECT_THAT([] { TriggerBox second("TB0042"); }, testing::ThrowsMessage<DeviceError>(testing::HasSubstr("in use")));
}

TEST_F(UsbTriggerBox, PulledOutWhileItPulsesItIsLostAndPluggedInAgainItPulses) {
  {
    PulseLog log;
    TriggerBox box("TB0042", log.sink());
    box.set({.period = 40ms});
    box.start(RigClock::now() + 2s);
    ASSERT_TRUE(soon([&] { return log.pulses().size() >= 2; }));
    gadget.unplug();
    EXPECT_TRUE(soon([&] { return box.lost(); }));
    EXPECT_THAT([&] { box.stop(); }, testing::ThrowsMessage<DeviceError>(testing::HasSubstr("was lost")));
    EXPECT_TRUE(soon([] { return capture::find_trigger_boxes().empty(); }));
    EXPECT_THAT([] { TriggerBox second("TB0042"); },
                testing::ThrowsMessage<DeviceError>(testing::HasSubstr("none on USB")));
  }
  gadget.plug_in();
  ASSERT_TRUE(soon([] { return listed("TB0042"); }));
  PulseLog log;
  TriggerBox box("TB0042", log.sink());
  box.set({.period = 40ms, .count = 5});
  box.start(RigClock::now() + 2s);
  EXPECT_TRUE(soon([&] { return log.pulses().size() == 5; }));
  EXPECT_EQ(log.pulses().front().number, 0U);
}

TEST_F(UsbTriggerBox, WhatAHostThatDiedLeftPulsingEndsByItself) {
  const auto host = std::filesystem::read_symlink("/proc/self/exe").string() + " --host-that-dies";
  ASSERT_EQ(std::system(host.c_str()), 0);
  EXPECT_TRUE(gadget.pulsing());
  EXPECT_TRUE(soon([&] { return gadget.pulses() >= 1; }));
  EXPECT_TRUE(soon([&] { return !gadget.pulsing(); })) << "three seconds without a word";
  EXPECT_FALSE(TriggerBox("TB0042").status().running);
}

}  // namespace
}  // namespace rotunda::vm
