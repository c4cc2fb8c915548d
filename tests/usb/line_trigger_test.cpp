// A take in trigger mode `line`: the trigger box on a mocked USB port pulses the Line0 of simulated GigE Vision
// cameras.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/rig_config.h"
#include "rig/daemon/rig_daemon.h"
#include "simulator/gige/trigger_box.h"
#include "simulator/gige/udp_socket.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"
#include "tests/usb/emulated_trigger_box.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using tests::EmulatedTriggerBox;

struct LineRig : ::testing::Test {
  std::filesystem::path folder = std::filesystem::temp_directory_path() / ("rotunda-line-" + std::to_string(getpid()));
  config::RigConfig rig;
  ~LineRig() override { std::filesystem::remove_all(folder); }

  void SetUp() override {
    if (const auto why_not = tests::enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "rig.yaml") << "name: line\n"
                                          "trigger: { mode: line, rate_hz: 20, pulse_width_us: 2000 }\n"
                                          "storage: { takes: takes, reserve_mb: 1 }\n"
                                          "cameras:\n"
                                          "  - { name: cam00, address: 127.0.0.1, exposure_us: 2000 }\n"
                                          "  - { name: cam01, address: 127.0.0.2, exposure_us: 2000 }\n";
    rig = config::load_rig(folder / "rig.yaml");
    rig.storage.takes = folder / "takes";
  }

  TakeProgress record(RigDaemon& daemon, std::uint64_t frame_sets) {
    const auto take = daemon.start_take({.name = "t", .frame_sets = frame_sets});
    auto progress = take->progress();
    for (int i = 0; i < 300 && !progress.closed; ++i) progress = take->wait_for_change(progress, 100ms);
    return progress;
  }
};

TEST_F(LineRig, EachPulseIsOneCompleteFrameSet) {
  tests::TestStudio studio({.cameras = 2, .width = 64, .height = 48, .trigger_box_port = 0});
  simulator::UdpSocket cable({.address = INADDR_LOOPBACK, .port = 0});
  const simulator::Endpoint line0{.address = INADDR_LOOPBACK, .port = (*studio).trigger_box_port()};
  EmulatedTriggerBox box({.fast_ppm = 50.0}, [&](unsigned line, bool high) {
    if (line == 0) cable.send(simulator::line_datagram({.high = high, .at = capture::RigClock::now()}), line0);
  });
  RigDaemon daemon(rig);
  const auto progress = record(daemon, 15);
  EXPECT_EQ(progress.failure, "");
  EXPECT_EQ(progress.frame_sets, 15U);
  EXPECT_EQ(progress.complete, 15U);
  EXPECT_EQ(box.pulses(), 15U);
  const capture::TakeReader take(folder / "takes" / "t");
  ASSERT_EQ(take.frame_set_count(), 15U);
  for (std::size_t i = 1; i < 15; ++i) {
    const auto before = take.read(i - 1, 0).frame, here = take.read(i, 0).frame;
    ASSERT_TRUE(before && here);
    EXPECT_LT(std::chrono::abs(here->exposure_start - before->exposure_start - 50ms), 25ms) << "a trigger a pulse";
  }
}

TEST_F(LineRig, ATakeWithoutABoxIsRefusedBeforeItBegins) {
  tests::TestStudio studio({.cameras = 2, .width = 64, .height = 48});
  RigDaemon daemon(rig);
  EXPECT_THROW(daemon.start_take({.name = "t", .frame_sets = 2}), DeviceError);
  EXPECT_FALSE(std::filesystem::exists(folder / "takes" / "t"));
}

TEST_F(LineRig, ABoxThatIsUnpluggedEndsTheTakeWithWhatThereIs) {
  tests::TestStudio studio({.cameras = 2, .width = 64, .height = 48});
  EmulatedTriggerBox box({}, [&](unsigned line, bool high) {
    if (line == 0 && high) (*studio).line0_edge(capture::RigClock::now());
  });
  RigDaemon daemon(rig);
  const auto take = daemon.start_take({.name = "t"});
  auto progress = take->progress();
  for (int i = 0; i < 100 && progress.frame_sets < 5; ++i) progress = take->wait_for_change(progress, 100ms);
  box.unplug();
  for (int i = 0; i < 100 && !progress.closed; ++i) progress = take->wait_for_change(progress, 100ms);
  EXPECT_TRUE(progress.closed);
  EXPECT_NE(progress.failure.find("was lost"), std::string::npos) << progress.failure;
  EXPECT_GE(capture::TakeReader(folder / "takes" / "t").frame_set_count(), 5U);
}

}  // namespace
}  // namespace rotunda::rig
