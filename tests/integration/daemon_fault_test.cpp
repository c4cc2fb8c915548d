// Every fault the simulated cameras know strikes a daemon that records: it survives, tells the holes, and no frame it
// keeps shows anything but what that camera saw at that time. docs/simulator-faults.md has the same as a table.
#include <fmt/format.h>
#include <sched.h>

#include <fstream>

#include "capture/take/take_reader.h"
#include "simulator/gige/control_socket.h"
#include "simulator/gige/fault_control.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using simulator::FaultKind;
using Nanoseconds = std::chrono::nanoseconds;

// One fault at one camera during one take.
struct FaultRow {
  FaultKind kind;
  std::string fault;         // as files and requests have it
  int fewest = 0, most = 0;  // holes that camera then has in the take
  Nanoseconds ahead{};       // of the frames' stamps before the truth
  bool ends_itself = false;  // rather than with the take
};
using FaultRows = std::vector<FaultRow>;

constexpr int kTriggers = 4;  // of each take
constexpr int kAll = kTriggers;
constexpr int kPacketSize = 1500;  // 16 packets a frame

std::string camera_name(std::size_t camera) {
  return fmt::format("cam{:02}", camera);
}

std::string entry(std::size_t camera, std::size_t trigger, const FaultRow& row) {
  const auto end = row.ends_itself ? "" : fmt::format(", for: {} triggers", kTriggers);
  return fmt::format("{{ camera: {}, at: trigger {}{}, {} }}", camera_name(camera), trigger, end, row.fault);
}

// The same faults twice: at the first half of the cameras by file, at the second half by socket.
class DaemonFaults : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    // Where the system allows it, for the cameras and the daemon alike: a busy machine's own holes are not asked for.
    const sched_param before_others{.sched_priority = 1};
    sched_setscheduler(0, SCHED_RR, &before_others);
  }
  // A studio whose cameras suffer `rows` from that trigger on.
  void serve(const FaultRows& rows, std::size_t from_trigger) {
    half_ = rows.size();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < 2 * half_; ++i) names.push_back(camera_name(i));
    studio_.emplace(TestStudioOptions{.cameras = 2 * half_, .width = kWidth, .height = kHeight});
    control_.emplace(
        simulator::FaultControlOptions{.script = write_script(rows, from_trigger), .socket = control_socket()}, names);
    control_->start(**studio_);
    const int cameras = static_cast<int>(2 * half_);
    daemon_ = start_daemon(write_rig({.cameras = cameras, .packet_size = kPacketSize, .rate_hz = 2.0}));
    wait_for_all_cameras();
  }
  void TearDown() override {
    EXPECT_TRUE(!daemon_ || daemon_->running()) << "the daemon did not survive: " << daemon_->err();
    daemon_.reset();
    control_.reset();
    studio_.reset();
  }

  std::filesystem::path control_socket() const { return folder() / "sim.sock"; }
  std::filesystem::path write_script(const FaultRows& rows, std::size_t from_trigger) const {
    const auto file = folder() / "faults.yaml";
    std::ofstream script(file);
    script << "seed: 3\nfaults:\n";
    for (std::size_t row = 0; row < rows.size(); ++row) script << "  - " << entry(row, from_trigger, rows[row]) << '\n';
    return file;
  }
  void ask(const std::string& request) {
    const auto answer = simulator::ask_control_socket(control_socket(), request);
    EXPECT_EQ(json::parse(answer)["ok"], true) << request << ": " << answer;
  }
  void wait_for_all_cameras() {
    wait_for_status([&](const json& now) {
      return std::all_of(now["cameras"].begin(), now["cameras"].end(),
                         [](const json& camera) { return camera["state"] == "streaming"; });
    });
  }

  // The daemon believes in a camera that let go of it until its next heartbeat.
  void wait_until_cameras_stream_again() {
    wait_for_status([&](const json&) {
      const auto now = studio_->stats();
      return std::all_of(now.begin(), now.end(),
                         [](const auto& camera) { return camera.has_controller && camera.is_acquiring; });
    });
    wait_for_all_cameras();
  }

  // Records, and holds every frame and every hole against what was wrong with its camera.
  void record(const std::string& name, const FaultRows& rows) {
    SCOPED_TRACE(name);
    for (std::size_t row = 0; row < rows.size(); ++row)
      if (!rows[row].fault.empty()) ask(entry(half_ + row, 1, rows[row]));
    const auto taken = rotunda({"take", "start", name, "--frames", std::to_string(kTriggers)});
    const auto report = verify(name, taken.exit_code);
    EXPECT_EQ(report["state"], "complete");
    const capture::TakeReader take(takes() / name);
    ASSERT_EQ(take.frame_set_count(), static_cast<std::size_t>(kTriggers)) << taken.out << taken.err;
    int holes = 0;
    for (std::size_t camera = 0; camera < 2 * half_; ++camera) {
      const FaultRow row = row_of(camera, rows);
      SCOPED_TRACE(fmt::format("{}: {}", camera_name(camera), row.fault));
      const int missing = report["cameras"][camera]["missing"];
      EXPECT_GE(missing, row.fewest);
      EXPECT_LE(missing, row.most) << status()["cameras"][camera].dump(1) << '\n' << daemon_->err();
      holes += missing;
      // How far a drifting clock has come by then is not told.
      if (row.kind != FaultKind::clock_drift) expect_true_pictures(take, camera, row.ahead);
    }
    EXPECT_EQ(taken.exit_code, holes > 0 ? 1 : 0) << taken.out << taken.err;
  }

  FaultRow row_of(std::size_t camera, const FaultRows& rows) const {
    return camera % half_ < rows.size() ? rows[camera % half_] : FaultRow{};
  }

  // That the faults of `rows` have fired since `before`, or none if there are no rows.
  void expect_fired(const FaultRows& rows, const std::vector<simulator::GigeStats>& before) const {
    const auto now = studio_->stats();
    for (std::size_t camera = 0; camera < 2 * half_; ++camera) {
      const FaultRow row = row_of(camera, rows);
      SCOPED_TRACE(fmt::format("{}: {}", camera_name(camera), row.fault));
      if (rows.empty()) {
        EXPECT_EQ(now[camera].faults.fired, before[camera].faults.fired);
      }
      if (!row.fault.empty()) {
        EXPECT_GT(now[camera].faults[row.kind], before[camera].faults[row.kind]);
      }
    }
  }
  void record_and_expect_fired(const std::string& name, const FaultRows& rows) {
    const auto before = studio_->stats();
    record(name, rows);
    expect_fired(rows, before);
  }

  void expect_true_pictures(const capture::TakeReader& take, std::size_t camera, Nanoseconds ahead) {
    for (std::size_t trigger = 0; trigger < kTriggers; ++trigger) {
      const auto slot = take.read(trigger, camera);
      if (!slot.frame) continue;
      const auto seen = studio_->picture(camera, slot.frame->exposure_start - ahead);
      const auto kept = slot.frame->image.bytes();
      EXPECT_TRUE(std::equal(kept.begin(), kept.end(), seen.begin(), seen.end())) << "trigger " << trigger;
    }
  }

  std::size_t half_ = 0;
  std::optional<TestStudio> studio_;
  std::optional<simulator::FaultControl> control_;
  std::unique_ptr<ScopedProgram> daemon_;
};

const FaultRows kPackets{
    {FaultKind::packet_loss, "packet_loss: 10%"},
    {FaultKind::packet_loss, "packet_loss: { rate: 30%, burst: 3 }", 0, kAll},
    {FaultKind::packet_loss, "packet_loss: 100%", kAll, kAll},
    {FaultKind::reorder, "reorder: 30%"},
    {FaultKind::reorder, "reorder: { rate: 100%, by: 5 }"},
    {FaultKind::duplicate, "duplicate: 50%"},
    {FaultKind::network_error, "network_error: 10%"},
    {FaultKind::stray_packet, "stray_packet: 100%"},
    {FaultKind::missing_trailer, "missing_trailer: 100%", kAll, kAll},
    {FaultKind::stall, "stall: {}", kAll, kAll},
};
const FaultRows kFrames{
    {FaultKind::late_frames, "late_frames: 100ms"},
    {FaultKind::late_frames, "late_frames: 1300ms", kAll, kAll},
    {FaultKind::corrupted_leader, "corrupted_leader: width", kAll, kAll},
    {FaultKind::corrupted_leader, "corrupted_leader: height", kAll, kAll},
    {FaultKind::corrupted_leader, "corrupted_leader: pixel_format", kAll, kAll},
    {FaultKind::wrong_payload_size, "wrong_payload_size: -5000", kAll, kAll},
    {FaultKind::wrong_payload_size, "wrong_payload_size: 5000", 0, kAll},
    {FaultKind::slow_registers, "slow_registers: 300ms"},
};
const FaultRows kTimes{
    {FaultKind::over_temperature, "over_temperature: 92"},
    {FaultKind::over_temperature, "over_temperature: { to: 92, stops_at: 85 }", kAll, kAll},
    {FaultKind::missed_trigger, "missed_trigger: { every: 2 }", 2, 2},
    {FaultKind::missed_trigger, "missed_trigger: 3", 3, 3, 0ns, true},
    {FaultKind::doubled_trigger, "doubled_trigger: 2", 0, 0, 0ns, true},
    {FaultKind::late_trigger, "late_trigger: 5ms"},
    {FaultKind::clock_step, "clock_step: 2ms", 0, 0, 2ms},
    {FaultKind::clock_step, "clock_step: -2ms", 0, 0, -2ms},
    {FaultKind::clock_drift, "clock_drift: 50ppm"},
};

// After these the daemon has to open the camera anew, or gets no more of it.
const FaultRows kLinks{
    {FaultKind::silence, "silence: 600ms", 1, kAll, 0ns, true},
    {FaultKind::silence, "silence: 5s", kAll - 1, kAll, 0ns, true},
    {FaultKind::reboot, "reboot: 2s", kAll - 1, kAll, 0ns, true},
    {FaultKind::control_stolen, "control_stolen: 1s", kAll - 1, kAll, 0ns, true},
    {FaultKind::control_stolen, "control_stolen: { for: 1s, exclusive: false }", kAll - 1, kAll, 0ns, true},
    {FaultKind::wrong_payload_size, "wrong_payload_size: { register: 5000 }, reboot: 1s", kAll - 1, kAll, 0ns, true},
    {FaultKind::wrong_payload_size, "wrong_payload_size: { register: -5000 }, reboot: 1s", kAll - 1, kAll, 0ns, true},
    {FaultKind::corrupted_leader, "corrupted_leader: random", kAll, kAll},
    {FaultKind::corrupted_leader, "corrupted_leader: block_id", kAll, kAll},
};

struct FaultFamily {
  std::string name;
  FaultRows rows;
  friend void PrintTo(const FaultFamily& family, std::ostream* out) { *out << family.name; }
};
class DaemonFaultsOf : public DaemonFaults, public testing::WithParamInterface<FaultFamily> {};

// The control run comes afterwards: that the faults are over, and were what cost the frames.
TEST_P(DaemonFaultsOf, CostNoMoreThanTheFramesTheyStrike) {
  ASSERT_NO_FATAL_FAILURE(serve(GetParam().rows, 1));
  record_and_expect_fired("struck", GetParam().rows);
  ask("clear");
  record_and_expect_fired("control", {});
}
INSTANTIATE_TEST_SUITE_P(Each, DaemonFaultsOf,
                         testing::Values(FaultFamily{"Packets", kPackets}, FaultFamily{"Frames", kFrames},
                                         FaultFamily{"Times", kTimes}),
                         [](const auto& family) { return family.param.name; });

TEST_F(DaemonFaults, OfTheLinkAreToldAndCamerasComeBack) {
  ASSERT_NO_FATAL_FAILURE(serve(kLinks, kTriggers + 1));
  record_and_expect_fired("control", {});
  const auto before = studio_->stats();
  record("links", kLinks);
  wait_until_cameras_stream_again();
  expect_fired(kLinks, before);
}

}  // namespace
}  // namespace rotunda::tests
