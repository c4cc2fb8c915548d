// Programs that know nothing of this house look at the simulated cameras: Aravis' own tools, and Wireshark's dissector
// at a capture of a take. A witness that is not installed is told and skipped.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <sstream>
#include <thread>

#include "tests/support/aravis_client.h"
#include "tests/support/gige_test_studio.h"
#include "tests/support/private_network.h"

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kPacketSize = 1500;

bool is_installed(const std::string& program) {
  return !output_of("command -v " + program).empty();
}

class Witness : public testing::Test {
 protected:
  void SetUp() override {
    const auto refusal = enter_private_network();
    if (!refusal.empty()) GTEST_SKIP() << refusal;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ = [] {
    std::string name = std::filesystem::temp_directory_path() / "witness-XXXXXX";
    return std::filesystem::path(mkdtemp(name.data()));
  }();
};

// dumpcap on the loopback, from construction to stop().
class Capture {
 public:
  explicit Capture(const std::filesystem::path& file) {
    const auto log = file.string() + ".log";
    posix_spawn_file_actions_t actions{};
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_CREAT | O_WRONLY, 0600);
    const std::string path = file.string();
    std::string words[] = {"dumpcap", "-q", "-i", "lo", "-B", "64", "-s", "0", "-w", path};
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (posix_spawnp(&pid_, "dumpcap", &actions, nullptr, arguments.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    for (int k = 0; k < 1000 && running() && !std::filesystem::exists(file); ++k) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(300ms);  // the file comes just before the socket listens
  }
  ~Capture() { stop(); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  bool running() {
    if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = -1;
    return pid_ > 0;
  }
  void stop() {
    if (!running()) return;
    std::this_thread::sleep_for(500ms);  // for what is still in its ring
    kill(pid_, SIGINT);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
};

// How often each value of `field` was dissected.
std::map<std::string, int> values_of(const std::filesystem::path& file, const std::string& field) {
  std::istringstream lines(output_of(
      fmt::format("tshark --enable-heuristic gvsp_udp -r '{}' -T fields -e {} 2>/dev/null", file.string(), field)));
  std::map<std::string, int> values;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) ++values[line];
  return values;
}

int packets(const std::filesystem::path& file, const std::string& filter) {
  return std::stoi(output_of(
      fmt::format("tshark --enable-heuristic gvsp_udp -r '{}' -Y '{}' 2>/dev/null | wc -l", file.string(), filter)));
}

void expect_whole_frame(AravisClient& client) {
  const auto frame = client.next_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->status, ARV_BUFFER_STATUS_SUCCESS);
}

// Discovery, control, streams with standard and extended ids, chunks, resend, test packets, PENDING_ACK, actions.
void take_everything(TestStudio& studio) {
  arv_update_device_list();
  AravisClient plain(studio.address(0), kPacketSize), rich(studio.address(1), kPacketSize);
  AravisError error;
  arv_camera_set_chunks(rich.camera(), "Timestamp,ExposureTime,LineStatusAll", error);
  error.check("chunks");
  rich.set("GevGVSPExtendedIDMode", "On");
  rich.set("UserSetSelector", "UserSet0");
  rich.execute("UserSetSave");
  plain.execute("GevSCPSFireTestPacket");
  for (auto* client : {&plain, &rich}) {
    client->trigger_by("Software");
    client->start({.frame_retention = 3s});
    for (int k = 0; k < 4; ++k) {
      client->execute("TriggerSoftware");
      expect_whole_frame(*client);
    }
    client->set("TriggerSource", "Action1");
  }
  ActionSender actions;
  EXPECT_EQ(actions.send(capture::RigClock::now() + 200ms, 2), std::vector<std::uint16_t>(2, 0));
  expect_whole_frame(plain);
  expect_whole_frame(rich);
  plain.stop();
  rich.stop();
}

}  // namespace

TEST_F(Witness, ArvToolListsReadsAndWrites) {
  if (!is_installed("arv-tool-0.8")) GTEST_SKIP() << "arv-tool-0.8 is not installed";
  TestStudio studio({.cameras = 3});
  const auto listed = output_of("arv-tool-0.8 2>&1");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_THAT(listed, HasSubstr(fmt::format("RS{:04} ({})", i, studio.address(i))));
  const auto written = output_of(
      "arv-tool-0.8 -a 127.0.0.2 control ExposureTime=1234 ExposureTime Width=80 Width DeviceUserID PtpStatus 2>&1");
  EXPECT_THAT(written, HasSubstr("ExposureTime = 1234"));
  EXPECT_THAT(written, HasSubstr("Width = 80"));
  EXPECT_THAT(written, HasSubstr("cam01"));
  EXPECT_THAT(written, HasSubstr("Slave"));
  const auto features = output_of("arv-tool-0.8 -a 127.0.0.3 values 2>&1");
  for (const auto name : {"BalanceRatio", "ChunkModeActive", "UserSetSelector", "GevIEEE1588", "TriggerDelay"})
    EXPECT_THAT(features, HasSubstr(name));
}

TEST_F(Witness, ArvCameraTestStreamsWithoutLoss) {
  if (!is_installed("arv-camera-test-0.8")) GTEST_SKIP() << "arv-camera-test-0.8 is not installed";
  TestStudio studio({.cameras = 1});
  const auto told = output_of(
      "arv-camera-test-0.8 --name=127.0.0.1 --frequency=10 --duration=3 --no-packet-socket --gv-packet-size=1500 "
      "--chunks=Timestamp,ExposureTime --features=TriggerMode=Off 2>&1");
  const auto number = [&](const std::string& label) {
    const auto at = told.find(label);
    const auto digit = at == std::string::npos ? at : told.find_first_of("0123456789", at + label.size());
    return digit == std::string::npos ? -1 : std::stoi(told.substr(digit));
  };
  EXPECT_GE(number("n_completed_buffers"), 15) << told;  // of 30; a busy machine starts late
  EXPECT_EQ(number("n_failures"), 0) << told;
  EXPECT_EQ(number("n_size_mismatch_errors"), 0) << told;
}

TEST_F(Witness, WiresharkFindsNothingMalformedInATake) {
  if (!is_installed("tshark") || !is_installed("dumpcap")) GTEST_SKIP() << "tshark is not installed";
  const auto file = folder_ / "take.pcapng";
  TestStudio studio({.cameras = 2, .width = 320, .height = 240});
  (*studio).set_faults({.seed = 7, .packet_loss = {.rate = 0.02}});
  Capture capture(file);
  if (!capture.running()) GTEST_SKIP() << "dumpcap may not capture here";
  take_everything(studio);
  capture.stop();

  const auto streamed = packets(file, "gvsp"), controlled = packets(file, "gvcp");
  EXPECT_GT(streamed, 400);
  EXPECT_GT(controlled, 200);
  EXPECT_EQ(packets(file, "(gvcp || gvsp) && (_ws.malformed || _ws.expert.severity >= 6291456)"), 0);  // warnings too
  const auto commands = values_of(file, "gvcp.cmd.command"), acknowledged = values_of(file, "gvcp.ack");
  for (const auto command : {"0x0002", "0x0040", "0x0080", "0x0084", "0x0086", "0x0100"})
    EXPECT_TRUE(commands.count(command)) << command << " was not named";
  for (const auto command : {"0x0003", "0x0081", "0x0085", "0x0087", "0x0089", "0x0101"})
    EXPECT_TRUE(acknowledged.count(command)) << command << " was not named";
  EXPECT_GT(packets(file, "gvsp.status == 0x0100"), 0);       // sent again
  EXPECT_GT(packets(file, "gvsp.payloadtype == 0x4001"), 0);  // with chunks
  EXPECT_GT(packets(file, "gvsp.blockid64"), 0);
}

}  // namespace rotunda::tests
