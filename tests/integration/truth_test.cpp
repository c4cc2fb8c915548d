// What rotunda-sim says is true against what its cameras send.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <thread>

#include "simulator/studio/frame_cache.h"
#include "tests/integration/house_test.h"
#include "tests/support/aravis_client.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

using TruthTest = StudioTest;

// By camera and start of the exposure.
std::map<std::pair<std::string, std::int64_t>, nlohmann::json> exposures_in(const fs::path& file) {
  std::map<std::pair<std::string, std::int64_t>, nlohmann::json> exposures;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    const auto exposure = nlohmann::json::parse(line);
    exposures[{exposure.at("camera"), exposure.at("exposure_start_ns")}] = exposure;
  }
  return exposures;
}

simulator::CacheEntry only_entry_in(const fs::path& cache) {
  const auto folder = fs::directory_iterator(cache)->path();
  auto entry = simulator::FrameCache({.folder = cache}).find({.text = "", .digest = folder.filename().string()});
  EXPECT_TRUE(entry);
  return std::move(*entry);
}

TEST_F(TruthTest, EveryReceivedFrameHasItsLineAndItsPicture) {
  constexpr std::size_t kFrames = 6;
  const auto truth = folder() / "truth", cache = folder() / "cache";
  const std::vector<std::string> arguments{
      "--rig", write_rig({.cameras = 2}).string(), "--truth", truth.string(), "--cache", cache.string(), "--exposure",
      "2500"};
  const auto sim = start("rotunda-sim", arguments);
  ASSERT_TRUE(sim->wait_for("cameras ready on")) << sim->err();
  std::vector<ReceivedFrame> frames;
  {
    AravisClient client("127.0.0.2", 8900);
    client.trigger_by("Software");
    client.start();
    while (frames.size() < kFrames) {
      client.execute("TriggerSoftware");
      auto frame = client.next_frame();
      ASSERT_TRUE(frame);
      frames.push_back(std::move(*frame));
      std::this_thread::sleep_for(110ms);
    }
  }
  sim->send(SIGKILL);
  const auto exposures = exposures_in(truth / "exposures.jsonl");
  const auto entry = only_entry_in(cache);
  for (const auto& frame : frames) {
    ASSERT_EQ(frame.status, ARV_BUFFER_STATUS_SUCCESS);
    const auto found = exposures.find({"cam01", frame.exposure_start.time_since_epoch().count()});
    ASSERT_NE(found, exposures.end());
    const auto& exposure = found->second;
    EXPECT_EQ(exposure.at("block"), frame.block);
    EXPECT_EQ(exposure.at("exposure_ns"), 2'500'000);
    const int act_frame = exposure.at("act_frame");
    EXPECT_EQ(entry.read(act_frame)->at(1), frame.pixels);
    for (const char* kind : {"meshes", "depth/cam01", "mattes/cam01"}) {
      const auto begins = fmt::format("frame{:06}.", act_frame);
      EXPECT_TRUE(std::any_of(fs::directory_iterator(truth / kind), fs::directory_iterator(), [&](const auto& item) {
        return item.path().filename().string().rfind(begins, 0) == 0;
      })) << kind;
    }
  }

  const auto again = start("rotunda-sim", arguments);  // all is there: nothing is rendered
  ASSERT_TRUE(again->wait_for("cameras ready on")) << again->err();
  EXPECT_THAT(again->err(), testing::Not(testing::HasSubstr("rendering ahead")));
}

}  // namespace
}  // namespace rotunda::tests
