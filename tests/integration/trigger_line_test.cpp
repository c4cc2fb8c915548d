// rotunda-sim with realistic clocks and a trigger line, through Aravis.
#include <netinet/in.h>

#include "simulator/gige/trigger_box.h"
#include "tests/integration/house_test.h"
#include "tests/support/aravis_client.h"

namespace rotunda::tests {
namespace {

using capture::RigClock;
using namespace std::chrono_literals;

class TriggerLine : public StudioTest {
 protected:
  // Of a person who stands still: there is little to render ahead.
  std::unique_ptr<ScopedProgram> start_sim_with(std::vector<std::string> options) {
    std::vector<std::string> all{"--rig", write_rig({.cameras = 2}).string(), "--act", "a-pose", "--no-cache"};
    all.insert(all.end(), options.begin(), options.end());
    auto sim = start("rotunda-sim", all);
    EXPECT_TRUE(sim->wait_for("cameras ready on")) << sim->err();
    return sim;
  }
};

// What is said to be the port: "... 127.0.0.1:PORT".
std::uint16_t told_port(const std::string& said) {
  const std::string before = "edges of Line0 on 127.0.0.1:";
  const auto at = said.find(before);
  return at == std::string::npos ? std::uint16_t{0}
                                 : static_cast<std::uint16_t>(std::stoi(said.substr(at + before.size())));
}

TEST_F(TriggerLine, AnEdgeExposesEveryCameraAtItsTimeByThatCamerasClock) {
  const auto sim = start_sim_with({"--clocks", "realistic", "--clock-seed", "5", "--trigger-box-port", "0"});
  const simulator::Endpoint line0{INADDR_LOOPBACK, told_port(sim->out() + sim->err())};
  ASSERT_NE(line0.port, 0);
  AravisClient master("127.0.0.1", 1500), slave("127.0.0.2", 1500);
  for (auto* client : {&master, &slave}) {
    client->trigger_by("Line0");
    client->start();
  }
  simulator::UdpSocket cable({INADDR_LOOPBACK, 0});
  std::chrono::nanoseconds most{};
  for (int i = 0; i < 3; ++i) {
    const auto at = RigClock::now();
    cable.send(simulator::line_datagram({.high = true, .at = at}), line0);
    cable.send(simulator::line_datagram({.high = false, .at = at + 1ms}), line0);
    const auto exact = master.next_frame(), wandering = slave.next_frame();
    ASSERT_TRUE(exact && wandering);
    EXPECT_EQ(exact->exposure_start, at);
    most = std::max(most, std::chrono::abs(wandering->exposure_start - at));
  }
  EXPECT_GT(most, 0ns) << "its clock has an error";
  EXPECT_LT(most, 1us) << "and PTP keeps it small";
}

}  // namespace
}  // namespace rotunda::tests
