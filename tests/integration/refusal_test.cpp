// Bad input and bad surroundings: one clear sentence, the right exit code, and what was there stays as it was.
#include <fstream>

#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

constexpr TestStudioOptions kTwoCameras{.cameras = 2, .width = kWidth, .height = kHeight};

class CommandRefusal : public HouseTest {};
class DaemonRefusal : public StudioTest {};

TEST_F(CommandRefusal, OfAMistypedCommandKnowsItsNeighbour) {
  const auto mistyped = rotunda({"tkae", "list"});
  EXPECT_EQ(mistyped.exit_code, 2);
  EXPECT_THAT(mistyped.err, AllOf(HasSubstr("tkae"), HasSubstr("did you mean \"take\"?")));
  const auto deeper = rotunda({"take", "verfy", "demo"});
  EXPECT_EQ(deeper.exit_code, 2);
  EXPECT_THAT(deeper.err, HasSubstr("did you mean \"verify\"?"));
  const auto no_option = rotunda({"take", "list", "--colour"});
  EXPECT_EQ(no_option.exit_code, 2);
  EXPECT_THAT(no_option.err, HasSubstr("--colour"));
}

TEST_F(CommandRefusal, OfCellsWithoutAnEdge) {
  for (const auto* cell : {"0", "-3mm"}) {
    const auto outcome = rotunda({"recon", "none", "--cell", cell});
    EXPECT_EQ(outcome.exit_code, 2) << cell;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("--cell"), HasSubstr("10mm")));
  }
}

TEST_F(CommandRefusal, WithoutADaemonSaysHowToStartOne) {
  const std::vector<std::vector<std::string>> commands{
      {"status"}, {"take", "start", "t", "--frames", "1"}, {"take", "stop"}};
  for (const auto& command : commands) {
    const auto outcome = rotunda(command);
    EXPECT_EQ(outcome.exit_code, 4) << command.front();
    EXPECT_THAT(outcome.err, AllOf(HasSubstr(socket().string()), HasSubstr("rotundad --rig")));
  }
  EXPECT_FALSE(fs::exists(takes()));
}

TEST_F(CommandRefusal, OfATakeThatIsNotThereListsTheOthers) {
  const auto outcome = rotunda({"take", "verify", "ghost"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("ghost"), HasSubstr(takes().string())));
}

TEST_F(CommandRefusal, OfUnknownKeysInARigFileNamesPlaceAndNeighbour) {
  const auto rig = folder() / "rig.yaml";
  std::ofstream(rig) << "name: studio\ntriger: { rate_hz: 25 }\ncameras:\n"
                        "  - { name: cam00, adress: 127.0.0.1 }\n";
  const auto outcome = run("rotundad", {"--rig", rig.string(), "--check"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr(rig.string() + ":2:1: triger"), HasSubstr("\"trigger\""),
                                 HasSubstr(rig.string() + ":4:20: cameras[0].adress"), HasSubstr("\"address\"")));
  const auto sim = run("rotunda-sim", {"--rig", rig.string()});
  EXPECT_EQ(sim.exit_code, 3);
  EXPECT_THAT(sim.err, HasSubstr(":2:1: triger"));
}

TEST_F(DaemonRefusal, OfASecondSimulatorNamesTheTakenAddress) {
  const auto rig = write_rig({.cameras = 2});
  const TestStudio first(kTwoCameras);
  const auto second = run("rotunda-sim", {"--rig", rig.string()});
  EXPECT_EQ(second.exit_code, 4);
  EXPECT_THAT(second.err, AllOf(HasSubstr("127.0.0.1:3956 is taken"), HasSubstr("another rotunda-sim")));
  const auto daemon = start_daemon(rig);
  EXPECT_EQ(camera_states(status()), "streaming streaming");  // the first one's
}

TEST_F(DaemonRefusal, OfAPixelFormatNamesTheCameras) {
  const TestStudio studio(kTwoCameras);
  const auto daemon = start_daemon(write_rig({.cameras = 2, .pixel_format = "BayerGB8"}));
  const auto now = status();
  EXPECT_EQ(now["state"], "idle");
  for (const auto& camera : now["cameras"])
    EXPECT_THAT(camera["problem"], AllOf(HasSubstr(camera["name"].get<std::string>()), HasSubstr("BayerGB8")));
  EXPECT_EQ(rotunda({"take", "start", "none", "--frames", "1"}).exit_code, 4);
  EXPECT_TRUE(contents_of(takes()).empty());
}

TEST_F(DaemonRefusal, OfASecondControllerLeavesTheFirstAlone) {
  const TestStudio studio(kTwoCameras);
  const auto rig = write_rig({.cameras = 2});
  const auto first = start_daemon(rig);
  const auto other_socket = folder() / "other.sock";
  auto second = start(
      "rotundad", {"--rig", rig.string(), "--takes", (folder() / "other").string(), "--socket", other_socket.string()});
  ASSERT_TRUE(second->wait_for(" ready: 0 of 2")) << second->err();
  const auto seen = run("rotunda", {"--daemon", other_socket.string(), "status", "--json"});
  const auto cameras = nlohmann::json::parse(seen.out)["cameras"];
  ASSERT_EQ(cameras.size(), 2u);
  for (const auto& camera : cameras)
    EXPECT_THAT(camera["problem"],
                AllOf(HasSubstr(camera["name"].get<std::string>()), HasSubstr("controlled by another program")));
  EXPECT_EQ(rotunda({"take", "start", "mine", "--frames", "3"}).exit_code, 0);
  EXPECT_EQ(verify("mine", 0)["complete"], 3);
}

TEST_F(DaemonRefusal, OfASecondDaemonOnItsSocket) {
  const TestStudio studio(kTwoCameras);
  const auto rig = write_rig({.cameras = 2});
  const auto first = start_daemon(rig);
  const auto second = run("rotundad", {"--rig", rig.string(), "--socket", socket().string()});
  EXPECT_EQ(second.exit_code, 4);
  EXPECT_THAT(second.err, HasSubstr("another daemon serves " + socket().string()));
  EXPECT_EQ(status()["state"], "armed");
}

TEST_F(DaemonRefusal, OfASecondTakeNamesTheRunningOne) {
  const TestStudio studio(kTwoCameras);
  const auto daemon = start_daemon(write_rig({.cameras = 2}));
  EXPECT_EQ(rotunda({"take", "stop"}).exit_code, 4);  // none is recording
  ASSERT_EQ(rotunda({"take", "start", "running"}).exit_code, 0);
  const auto second = rotunda({"take", "start", "second", "--frames", "1"});
  EXPECT_EQ(second.exit_code, 4);
  EXPECT_THAT(second.err, AllOf(HasSubstr("running"), HasSubstr("rotunda take stop")));
  EXPECT_FALSE(fs::exists(takes() / "second"));
  EXPECT_EQ(rotunda({"take", "stop"}).exit_code, 0);
  verify("running", 0);
}

TEST_F(DaemonRefusal, OfADiskWithoutRoomTellsFolderFreeAndNeededBytes) {
  const TestStudio studio(kTwoCameras);
  const auto daemon = start_daemon(write_rig({.cameras = 2, .reserve_mb = 1e9}));
  const auto refused = rotunda({"take", "start", "big", "--frames", "1"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err, AllOf(HasSubstr(folder().string()), HasSubstr("1000000000000000")));
  EXPECT_THAT(refused.err, ContainsRegex("[0-9]+ bytes.*free|free.*[0-9]+ bytes"));
  EXPECT_TRUE(contents_of(takes()).empty());
  EXPECT_EQ(status()["state"], "armed");
}

}  // namespace
}  // namespace rotunda::tests
