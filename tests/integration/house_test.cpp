#include "tests/integration/house_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "capture/calibration_file.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/private_network.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;

std::string rig_text(const SmallRig& rig, const std::string& name) {
  std::string text = fmt::format(
      "name: {0}\ncalibration: {0}.calibration.yaml\n"
      "trigger: {{ mode: action, rate_hz: {1}, lead_periods: {8}, interface: 127.0.0.1 }}\n"
      "storage: {{ reserve_mb: {2}, queue_frame_sets: {7} }}\n"
      "camera_defaults: {{ pixel_format: {3}, width: {4}, height: {5}, packet_size: {6} }}\ncameras:\n",
      name, rig.rate_hz, rig.reserve_mb, rig.pixel_format, rig.width, rig.height, rig.packet_size, rig.queue_frame_sets,
      rig.lead_periods);
  for (int i = 0; i < rig.cameras; ++i)
    text += fmt::format("  - {{ name: cam{:02}, address: 127.0.0.{} }}\n", i, i + 1);
  return text;
}

}  // namespace

HouseTest::HouseTest() {
  auto name = (fs::temp_directory_path() / "rotunda-house-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::system_error(errno, std::generic_category(), "mkdtemp " + name);
  folder_ = name;
}

HouseTest::~HouseTest() {
  std::error_code best_effort;
  if (!HasFailure()) fs::remove_all(folder_, best_effort);
}

std::unique_ptr<ScopedProgram> HouseTest::start(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), fmt::format("{}/{}", ROTUNDA_BINARY_DIR, program));
  return std::make_unique<ScopedProgram>(arguments, folder_ / fmt::format("{:02}-{}", programs_++, program));
}

Outcome HouseTest::run(const std::string& program, std::vector<std::string> arguments) {
  const auto child = start(program, std::move(arguments));
  const int exit_code = child->wait();
  return {exit_code, child->out(), child->err()};
}

Outcome HouseTest::rotunda(std::vector<std::string> arguments) {
  const std::vector<std::string> where{"--takes", takes().string(), "--daemon", socket().string()};
  arguments.insert(arguments.begin(), where.begin(), where.end());
  return run("rotunda", std::move(arguments));
}

void StudioTest::SetUp() {
  if (const auto why_not = enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
}

fs::path StudioTest::write_rig(const SmallRig& rig, const std::string& name) {
  capture::write_calibration(
      folder() / (name + ".calibration.yaml"),
      simulator::camera_layout({.cameras = std::max(2, rig.cameras), .width = rig.width, .height = rig.height}));
  const auto file = folder() / (name + ".yaml");
  std::ofstream(file) << rig_text(rig, name);
  return file;
}

std::unique_ptr<ScopedProgram> StudioTest::start_sim(const fs::path& rig) {
  auto sim = start("rotunda-sim", {"--rig", rig.string(), "--no-cache"});
  EXPECT_TRUE(sim->wait_for("cameras ready on")) << sim->err();
  return sim;
}

std::unique_ptr<ScopedProgram> StudioTest::start_daemon(const fs::path& rig, std::vector<std::string> more) {
  std::vector<std::string> arguments{"--rig", rig.string(), "--takes", takes().string(), "--socket", socket().string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  if (std::find(more.begin(), more.end(), "--surfaces") == more.end()) arguments.push_back("--no-surfaces");
  auto daemon = start("rotundad", arguments);
  EXPECT_TRUE(daemon->wait_for(" ready: ")) << daemon->err();
  return daemon;
}

json StudioTest::status() {
  const auto outcome = rotunda({"status", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return json::parse(outcome.out, nullptr, false);
}

json StudioTest::wait_for_status(const std::function<bool(const json&)>& wanted) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  auto now = status();
  while (!testing::Test::HasFailure() && !wanted(now)) {
    if (std::chrono::steady_clock::now() > end) ADD_FAILURE() << "it stays so: " << now.dump(2);
    std::this_thread::sleep_for(100ms);
    now = status();
  }
  return now;
}

json StudioTest::verify(const std::string& take, int exit_code) {
  const auto outcome = rotunda({"take", "verify", take, "--json"});
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.out << outcome.err;
  return json::parse(outcome.out, nullptr, false);
}

std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  if (!fs::exists(folder)) return contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    contents[entry.path().lexically_relative(folder).string()] = entry.is_regular_file() ? text_of(entry.path()) : "";
  return contents;
}

std::string camera_states(const json& status) {
  std::string states;
  for (const auto& camera : status.at("cameras"))
    states += (states.empty() ? "" : " ") + camera.at("state").get<std::string>();
  return states;
}

}  // namespace rotunda::tests
