#include "rig/preflight.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "rig/machine_facts.h"

namespace rotunda::rig {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint32_t kStudioNet = 0x0A000001, kMask24 = 0xFFFFFF00;  // 10.0.0.1/24

// Ten 720 x 576 cameras at 25 Hz on one ten-gigabit link, all as it should be.
PreflightFacts studio() {
  config::RigConfig rig;
  rig.trigger.interface_address = "10.0.0.1";
  RigStatus status{.rig = "studio", .state = "live", .trigger = "action", .rate_hz = 25.0};
  CalibrationFacts calibration{.file = "calibration.yaml", .problem = "", .cameras = {}, .age_days = 2.0};
  for (int i = 0; i < 10; ++i) {
    config::CameraConfig camera;
    camera.name = fmt::format("cam{:02}", i);
    camera.find_by = "serial";
    camera.device = fmt::format("SN{}", i);
    rig.cameras.push_back(camera);
    calibration.cameras.push_back(camera.name);
    CameraStatus told;
    told.name = camera.name;
    told.state = "streaming";
    told.pixel_format = "BayerRG8";
    told.width = 720;
    told.height = 576;
    told.offset_us = 20.0;
    status.cameras.push_back(told);
  }
  status.spread_p99_us = 40.0;
  PreflightFacts facts;
  facts.rig = rig;
  facts.status = status;
  facts.links = {{.name = "eth0", .address = kStudioNet, .netmask = kMask24, .mtu = 9000, .speed_mbit = 10000}};
  facts.socket_buffer_bytes = 32 << 20;
  facts.disk = {.folder = "/takes", .writable = true, .free_bytes = 2'000'000'000'000, .bytes_per_second = 800e6};
  facts.clock = {.tai_offset_s = 37, .synchronised = true};
  facts.calibration = calibration;
  facts.hottest_celsius = 55.0;
  return facts;
}

std::vector<Finding> bad_ones(const PreflightFacts& facts) {
  auto findings = preflight(facts);
  std::erase_if(findings, [](const Finding& finding) { return finding.verdict == Verdict::good; });
  return findings;
}

// The one thing that is found.
Finding the_finding(const PreflightFacts& facts) {
  const auto findings = bad_ones(facts);
  std::string all;
  for (const auto& finding : findings) all += lines_of(finding);
  EXPECT_EQ(findings.size(), 1U) << all;
  if (findings.empty()) throw std::runtime_error("nothing was found");
  EXPECT_NE(findings[0].cure, "");
  return findings[0];
}

TEST(Preflight, FindsNothingInAGoodStudio) {
  EXPECT_THAT(bad_ones(studio()), IsEmpty());
  EXPECT_GE(preflight(studio()).size(), 9U) << "what is good is told too";
  EXPECT_THAT(why_not_record(preflight(studio())), IsEmpty());
}

TEST(Preflight, CountsWhatTheCamerasSend) {
  EXPECT_DOUBLE_EQ(bytes_per_second(studio()), 10 * 720 * 576 * 25.0);
  auto packed = studio();
  for (auto& camera : packed.status->cameras) camera.pixel_format = "BayerRG12p";
  EXPECT_DOUBLE_EQ(bytes_per_second(packed), 1.5 * 10 * 720 * 576 * 25.0);
}

TEST(Preflight, ANarrowLinkIsToldWithItsArithmetic) {
  auto facts = studio();
  facts.links[0].speed_mbit = 1000;
  facts.rig->trigger.rate_hz = 27.0;
  const auto finding = the_finding(facts);
  EXPECT_EQ(finding.verdict, Verdict::stop) << "a take would be refused";
  EXPECT_EQ(finding.what, "link eth0");
  EXPECT_THAT(finding.measured,
              AllOf(HasSubstr("10 cameras x"), HasSubstr("x 27 Hz"), HasSubstr("of the 900.0 usable")));
}

TEST(Preflight, ALinkMayBeFilledToNineTenths) {
  auto facts = studio();
  facts.links[0].speed_mbit = 1000;  // 0.876 of it at 25 Hz
  EXPECT_THAT(bad_ones(facts), IsEmpty());
}

TEST(Preflight, CamerasThatNoLinkLeadsToAreNamed) {
  auto facts = studio();
  facts.status->cameras[4].address = "192.168.7.7";
  EXPECT_THAT(the_finding(facts).measured, AllOf(HasSubstr("no link"), HasSubstr("cam04")));
}

TEST(Preflight, AMissingCameraIsToldAndNoneAtAllStopsTheRig) {
  auto facts = studio();
  facts.status->cameras[2].state = "lost";
  facts.status->cameras[2].problem = "cam02 no longer answers";
  EXPECT_THAT(lines_of(the_finding(facts)), AllOf(HasSubstr("LOOK"), HasSubstr("cam02 no longer answers")));
  for (auto& camera : facts.status->cameras) camera.state = "lost";
  EXPECT_THAT(why_not_record(preflight(facts)), ElementsAre(HasSubstr("cameras: none streams")));
}

TEST(Preflight, ADiskThatIsFullOrForbiddenStopsTheRig) {
  auto facts = studio();
  facts.disk.free_bytes = 1'000'000'000;  // 2048 MB are kept
  EXPECT_THAT(why_not_record(preflight(facts)),
              ElementsAre(HasSubstr("1000 MB free, and storage.reserve_mb keeps 2048")));
  facts = studio();
  facts.disk.writable = false;
  EXPECT_THAT(why_not_record(preflight(facts)), ElementsAre(HasSubstr("cannot be written")));
}

TEST(Preflight, ADiskThatIsNearlyFullOrSlowIsLookedAt) {
  auto facts = studio();
  facts.disk.free_bytes = 2'048'000'000 + 30'000'000'000;  // 289 s at 104 MB/s
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("4 min of recording"));
  facts = studio();
  facts.disk.bytes_per_second = 120e6;
  EXPECT_THAT(lines_of(the_finding(facts)), AllOf(HasSubstr("writes 120 MB/s"), HasSubstr("this rig needs 104 MB/s")));
}

TEST(Preflight, ACalibrationThatIsMissingBrokenOfAnotherRigOrOldIsTold) {
  auto facts = studio();
  facts.calibration->age_days = 45.0;
  EXPECT_EQ(the_finding(facts).verdict, Verdict::note);
  facts.calibration->cameras.pop_back();
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("does not know cam09"));
  facts.calibration->problem = "calibration.yaml:3:1: cameras: is missing";
  EXPECT_THAT(the_finding(facts).measured, HasSubstr(":3:1:"));
  facts.calibration.reset();
  EXPECT_THAT(the_finding(facts).cure, HasSubstr("calibration: FILE"));
}

TEST(Preflight, ClocksThatAreOffAreNamed) {
  auto facts = studio();
  facts.status->cameras[6].offset_us = -2500.0;
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("cam06 by -2.5 ms"));
  facts = studio();
  facts.status->spread_p99_us = 4200.0;
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("4.2 ms apart"));
  facts = studio();
  facts.status->cameras[3].clock = "model";
  facts.status->cameras[3].clock_error_us = 3000.0;
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("cam03 by 3.0 ms (model)"));
  facts = studio();
  facts.clock.synchronised = false;
  EXPECT_EQ(the_finding(facts).what, "clock");
}

TEST(Preflight, SmallBuffersSmallPacketsAndHeatAreTold) {
  auto facts = studio();
  facts.socket_buffer_bytes = 212992;
  EXPECT_THAT(the_finding(facts).measured, HasSubstr("212992"));
  facts = studio();
  facts.links[0].mtu = 1500;
  EXPECT_THAT(lines_of(the_finding(facts)), AllOf(HasSubstr("note"), HasSubstr("ip link set eth0 mtu 9000")));
  facts = studio();
  facts.hottest_celsius = 97.0;
  facts.status->cameras[1].temperature_c = 80.0;
  facts.status->cameras[2].temperature_c = 45.0;
  EXPECT_EQ(the_finding(facts).measured, "this machine 97, cam01 80 degrees");
}

TEST(Preflight, LooksAtAMachineWithoutARig) {
  const auto facts = machine_facts(::testing::TempDir());
  EXPECT_TRUE(facts.disk.writable);
  EXPECT_GT(facts.disk.free_bytes, 0U);
  EXPECT_GT(facts.socket_buffer_bytes, 0U);
  EXPECT_THAT(why_not_record(preflight(facts)), IsEmpty());
}

TEST(DiskTrial, MeasuresLeavesNothingAndCanBeEnded) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "rotunda_disk_trial";
  std::filesystem::create_directories(folder);
  const auto rate = measure_disk(folder, {.bytes = 8'000'000});
  ASSERT_TRUE(rate);
  EXPECT_GT(*rate, 0.0);
  EXPECT_FALSE(measure_disk(folder, {.go_on = [] { return false; }}));
  EXPECT_FALSE(measure_disk("/nowhere/at/all", {}));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
}

}  // namespace
}  // namespace rotunda::rig
