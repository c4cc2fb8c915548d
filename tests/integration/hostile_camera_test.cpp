// Something that answers at a camera's address and means no good, or is badly broken: that camera is refused with the
// reason, and the daemon goes on recording with the others.
#include <netinet/in.h>
#include <sys/stat.h>

#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "capture/take/take_reader.h"
#include "tests/integration/house_test.h"
#include "tests/support/bare_device.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

struct Hostility {
  std::string name;
  BareDeviceOptions device;
  std::string reason;  // that the daemon gives
  bool fatal = false;  // to a program that trusts it
};

std::string repeated(int times, const std::function<std::string(int)>& each) {
  std::string all;
  for (int i = 0; i < times; ++i) all += each(i);
  return all;
}

BareDeviceOptions described(const std::string& nodes) {
  return {.description = bare_description(nodes)};
}

// `pipe`: a file of this machine that nobody writes to. What is not fatal, Aravis or its XML library withstands; the
// daemon gives the reason all the same.
std::vector<Hostility> hostilities(const std::filesystem::path& pipe) {
  const auto whole = bare_description("<Integer Name=\"Width\"><Value>160</Value></Integer>");
  return {
      {"noise for a description", {.description = std::string(3000, '\x8f')}, "cannot be opened as a camera"},
      {"half a description", {.description = whole.substr(0, whole.size() / 2)}, "cannot be opened as a camera"},
      {"four gigabytes of description", {.url = "Local:bare.xml;1000;ffffffff"}, "bytes long", true},
      {"a file of this machine without an end or a word", {.url = "File://" + pipe.string()}, "lies elsewhere", true},
      {"an endless file of this machine", {.url = "File:///dev/zero"}, "lies elsewhere"},
      {"a page of somebody's", {.url = "http://127.0.0.1:9/bare.xml"}, "lies elsewhere"},
      {"a url without an end", {.url = "Local:" + std::string(600, 'A')}, "no place that can be read"},
      {"a value that needs itself", described("<Integer Name=\"Width\"><pValue>Width</pValue></Integer>"),
       "needs itself", true},
      {"two values that need each other",
       described(
           "<Integer Name=\"Width\"><pValue>W</pValue></Integer>"
           "<IntSwissKnife Name=\"W\"><pVariable Name=\"X\">Width</pVariable><Formula>X+1</Formula></IntSwissKnife>"),
       "needs itself", true},
      {"sixty thousand formulas in a row",
       described(repeated(60'000,
                          [](int i) {
                            return fmt::format(
                                "<IntSwissKnife Name=\"{}\"><pVariable Name=\"X\">N{}</pVariable>"
                                "<Formula>X+1</Formula></IntSwissKnife>",
                                i == 0 ? "Width" : fmt::format("N{}", i), i + 1);
                          })),
       "in a row", true},
      {"values that double thirty times",
       described(repeated(30,
                          [](int i) {
                            return fmt::format(
                                "<IntSwissKnife Name=\"{}\"><pVariable Name=\"A\">N{}</pVariable>"
                                "<pVariable Name=\"B\">N{}</pVariable><Formula>A+B</Formula></IntSwissKnife>",
                                i == 0 ? "Width" : fmt::format("N{}", i), i + 1, i + 1);
                          })),
       "steps", true},
      {"elements nested ten thousand deep",
       described(repeated(10'000, [](int) { return std::string("<Group>"); }) +
                 repeated(10'000, [](int) { return std::string("</Group>"); })),
       "deep"},
      {"a billion laughs",
       {.description =
            "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY a0 \"ha\">" +
            repeated(30, [](int i) { return fmt::format("<!ENTITY a{} \"&a{};&a{};\">", i + 1, i, i); }) +
            "]><RegisterDescription><Integer Name=\"Width\"><Value>&a30;</Value></Integer></RegisterDescription>"},
       "no whole XML"},
      {"answers cut short",
       {.spoil = [](std::vector<std::uint8_t>& datagram) { datagram.resize(datagram.size() / 2); }},
       "does not let its description be read"},
      {"answers to nothing that was asked",
       {.spoil = [](std::vector<std::uint8_t>& datagram) { datagram[3] ^= 0x40; }},
       "does not let its description be read"},
      {"answers longer than asked for",
       {.spoil = [](std::vector<std::uint8_t>& datagram) { datagram.resize(datagram.size() + 9000, 0xFF); }},
       "does not let its description be read"},
  };
}

class HostileCamera : public StudioTest {
 protected:
  std::filesystem::path pipe() const {
    const auto path = folder() / "pipe";
    mkfifo(path.c_str(), 0600);
    return path;
  }
  void serve(int cameras) {
    studio_.emplace(TestStudioOptions{.cameras = 2, .width = kWidth, .height = kHeight});
    daemon_ = start_daemon(write_rig({.cameras = cameras}));
  }
  json expect_told(const BareDevice& device, const std::string& reason) {
    const auto told = wait_for_status([&](const json& now) {
      const auto& camera = now["cameras"][2];
      return device.answered() > 0 && camera["state"] == "lost" &&
             camera["problem"].get<std::string>().find(reason) != std::string::npos;
    });
    EXPECT_TRUE(daemon_->running()) << daemon_->err();
    return told;
  }

  // Of this loopback, but those of the cameras.
  static std::vector<std::uint16_t> udp_ports() {
    std::vector<std::uint16_t> ports;
    std::ifstream table("/proc/net/udp");
    std::string line, number, local;
    for (std::getline(table, line); std::getline(table, line);) {
      std::istringstream(line) >> number >> local;
      const auto port = static_cast<std::uint16_t>(std::stoi(local.substr(local.find(':') + 1), nullptr, 16));
      if (port != simulator::kGvcpPort) ports.push_back(port);
    }
    return ports;
  }
  void expect_true_pictures(const std::string& name) const {
    const capture::TakeReader take(takes() / name);
    for (std::size_t set = 0; set < take.frame_set_count(); ++set)
      for (std::size_t camera = 0; camera < 2; ++camera) {
        const auto slot = take.read(set, camera);
        ASSERT_TRUE(slot.frame) << to_string(*slot.missing_because);
        const auto seen = studio_->picture(camera, slot.frame->exposure_start);
        const auto kept = slot.frame->image.bytes();
        EXPECT_TRUE(std::equal(kept.begin(), kept.end(), seen.begin(), seen.end())) << "frame set " << set;
      }
  }

  std::optional<TestStudio> studio_;
  std::unique_ptr<ScopedProgram> daemon_;
};

TEST_F(HostileCamera, IsRefusedWithItsReasonAndTheOthersRecord) {
  serve(3);
  const auto take = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start",
                                      "all", "--frames", "100000"});
  wait_for_status([](const json& now) { return now["take"]["frame_sets"] >= 2; });
  for (const auto& hostility : hostilities(pipe())) {
    SCOPED_TRACE(hostility.name);
    auto options = hostility.device;
    options.first_address = 3;
    const BareDevice device(options);
    const auto told = expect_told(device, hostility.reason);
    if (HasFailure()) return;
    EXPECT_THAT(told["cameras"][2]["problem"].get<std::string>(), HasSubstr("127.0.0.3"));
    EXPECT_EQ(told["state"], "recording");
  }
  EXPECT_EQ(rotunda({"take", "stop"}).exit_code, 1);
  EXPECT_EQ(take->wait(), 1) << take->err();
  const auto report = verify("all", 1);
  EXPECT_EQ(report["cameras"][0]["missing"], 0);
  EXPECT_EQ(report["cameras"][1]["missing"], 0);
}

// The control run: what the look at descriptions keeps away from the daemon.
TEST_F(HostileCamera, TakesDownAProgramThatTrustsIt) {
  const auto open_unguarded = [&](const std::string& name, BareDeviceOptions options) {
    options.first_address = 3;
    const BareDevice device(options);
    auto end = run_program({ROTUNDA_UNGUARDED_CAMERA, "127.0.0.3"}, folder() / name);
    EXPECT_GT(device.answered(), 0U);
    return end;
  };
  const auto sound = open_unguarded("sound", described("<Integer Name=\"Width\"><Value>160</Value></Integer>"));
  EXPECT_EQ(sound.exit_code, 0) << sound.err;
  EXPECT_EQ(sound.out, "160\n");
  for (const auto& hostility : hostilities(pipe())) {
    const auto end = open_unguarded(hostility.name, hostility.device);
    EXPECT_EQ(end.exit_code > 128, hostility.fatal) << hostility.name << ": " << end.exit_code << "\n" << end.err;
  }
}

TEST_F(HostileCamera, ThatAsksForBuffersManyTimesItsPicturesIsNotBelieved) {
  studio_.emplace(TestStudioOptions{.cameras = 3, .width = kWidth, .height = kHeight});
  (**studio_).set_faults(2, {.wrong_payload_size = {.register_change = 3'000'000'000}});
  daemon_ = start_daemon(write_rig({.cameras = 3}));
  const auto told = wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming lost"; });
  EXPECT_THAT(told["cameras"][2]["problem"].get<std::string>(), HasSubstr("PayloadSize"));
  EXPECT_GT(studio_->stats()[2].faults[simulator::FaultKind::wrong_payload_size], 0U);
  (**studio_).set_faults({});
  wait_for_status([](const json& now) { return camera_states(now) == "streaming streaming streaming"; });
  EXPECT_EQ(rotunda({"take", "start", "whole", "--frames", "3"}).exit_code, 0);
  EXPECT_EQ(verify("whole", 0)["complete"], 3);
}

// Datagrams from anybody to a streaming camera's port: whatever they say, they are not that camera's.
TEST_F(HostileCamera, NoiseOnTheStreamsPortsCostsNoFrame) {
  serve(2);
  ASSERT_EQ(rotunda({"take", "start", "control", "--frames", "4"}).exit_code, 0);
  const auto take = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start",
                                      "noisy", "--frames", "12"});
  simulator::UdpSocket stranger({INADDR_LOOPBACK + 8, 0});
  std::mt19937 random(3);
  std::uint64_t sent = 0;
  while (take->running()) {
    for (const auto port : udp_ports())
      for (int i = 0; i < 20; ++i, ++sent) {
        std::vector<std::uint8_t> datagram(random() % 1500);
        for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random());
        if (datagram.size() > 8 &&
            i % 2 == 0) {  // the look of a leader, payload or trailer of a block near the present
          datagram[0] = datagram[1] = datagram[2] = 0;
          datagram[3] = static_cast<std::uint8_t>(random() % 16);
          datagram[4] = static_cast<std::uint8_t>(1 + random() % 3);
        }
        stranger.send(datagram, {INADDR_LOOPBACK, port});
      }
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_GT(sent, 1000U);
  EXPECT_TRUE(daemon_->running()) << daemon_->err();
  EXPECT_EQ(take->wait(), 0) << take->err();
  expect_true_pictures("noisy");
}

}  // namespace
}  // namespace rotunda::tests
