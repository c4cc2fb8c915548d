// The simulated studio lets go wrong what it was told to, by file and by
// socket, and counts it; the daemon bears it.
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/integration/house_test.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class Faults : public StudioTest {
 protected:
  fs::path control() const { return folder() / "sim.sock"; }
  fs::path write_faults(const std::string& text) const {
    const auto file = folder() / "faults.yaml";
    std::ofstream(file) << text;
    return file;
  }
  // Of a person who stands still: there is little to render ahead.
  std::unique_ptr<ScopedProgram> start_faulty_sim(const fs::path& rig, const std::string& faults) {
    auto sim = start("rotunda-sim", {"--rig", rig.string(), "--act", "a-pose", "--no-cache", "--faults",
                                     write_faults(faults).string(), "--control", control().string()});
    EXPECT_TRUE(sim->wait_for("cameras ready on")) << sim->err();
    return sim;
  }
  Outcome ask(const std::string& request) { return run("rotunda-sim", {"fault", control().string(), request}); }
  json sim_status() {
    const auto answer = ask("status");
    EXPECT_EQ(answer.exit_code, 0) << answer.err;
    return json::parse(answer.out, nullptr, false);
  }
};

TEST_F(Faults, FromAFileAndLiveAreCountedAndBorneByTheDaemon) {
  const auto rig = write_rig({.cameras = 2});
  const auto sim = start_faulty_sim(rig,
                                    "seed: 5\n"
                                    "faults:\n"
                                    "  - { camera: cam00, packet_loss: 10% }\n"
                                    "  - { camera: cam01, duplicate: 50% }\n");
  const auto daemon = start_daemon(rig);
  ASSERT_EQ(rotunda({"take", "start", "whole", "--frames", "4"}).exit_code, 0);
  EXPECT_EQ(verify("whole", 0)["complete"], 4) << "resends recover what is lost";
  const auto before = sim_status();
  EXPECT_GT(before["cameras"][0]["faults"]["packet_loss"], 0);
  EXPECT_GT(before["cameras"][1]["faults"]["duplicate"], 0);
  EXPECT_EQ(before["faults"]["missed_trigger"], 0);

  ASSERT_EQ(ask("clear").exit_code, 0);
  EXPECT_EQ(ask("cam01: { missed_trigger: { every: 2 } }").exit_code, 0);
  EXPECT_EQ(rotunda({"take", "start", "holes", "--frames", "6"}).exit_code, 1);
  const auto report = verify("holes", 1);
  EXPECT_EQ(report["cameras"][0]["missing"], 0) << report.dump(2);
  EXPECT_EQ(report["cameras"][1]["missing"], 3) << report.dump(2);
  EXPECT_GE(sim_status()["faults"]["missed_trigger"], 3);

  const auto unknown = ask("cam07: { silence: 2s }");
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_THAT(unknown.err, HasSubstr("cam07: unknown; expected all, or cameras out of cam00, cam01"));

  ASSERT_EQ(ask("clear").exit_code, 0);
  ASSERT_EQ(ask("cam01: { reboot: 3s }").exit_code, 0);
  wait_for_status([](const auto& now) { return camera_states(now) != "streaming streaming"; });
  wait_for_status([](const auto& now) { return camera_states(now) == "streaming streaming"; });
  EXPECT_EQ(sim_status()["cameras"][1]["faults"]["reboot"], 1);
  EXPECT_EQ(rotunda({"take", "start", "after", "--frames", "2"}).exit_code, 0);

  sim->send(SIGTERM);
  EXPECT_EQ(sim->wait(), 0);
  EXPECT_THAT(sim->out(), HasSubstr("cam00: packet_loss "));
  EXPECT_THAT(sim->out(), HasSubstr("missed_trigger "));
  EXPECT_FALSE(fs::exists(control()));
}

TEST_F(Faults, AreRefusedWithTheirPlace) {
  const auto rig = write_rig({.cameras = 2});
  const auto refused = run("rotunda-sim", {"--rig", rig.string(), "--faults",
                                           write_faults("faults:\n  - { camera: cam07, silence: 2 }\n").string()});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("faults.yaml:2:15: faults[0].camera: expected all, or "
                                     "cameras out of cam00, cam01"));
  EXPECT_THAT(refused.err, HasSubstr("faults.yaml:2:31: faults[0].silence.for: expected a duration"));
  EXPECT_THAT(refused.err, Not(HasSubstr("rendering"))) << "before anything is made";
  const auto nobody = ask("status");
  EXPECT_EQ(nobody.exit_code, 4);
  EXPECT_THAT(nobody.err, HasSubstr("no rotunda-sim listens here"));
}

}  // namespace
}  // namespace rotunda::tests
