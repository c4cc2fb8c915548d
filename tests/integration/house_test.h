#pragma once
// What the tests of whole programs share: a folder of their own, the house's programs, and a small rig of three
// cameras of 160 x 128 pixels at 4 Hz, slow enough for sanitized programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/scoped_program.h"

namespace rotunda::tests {

inline constexpr double kRate = 4.0;  // frame sets a second
inline constexpr int kWidth = 160, kHeight = 128;

struct SmallRig {
  int cameras = 3;
  int width = kWidth, height = kHeight;
  std::string pixel_format = "BayerRG8";
  double reserve_mb = 1.0;
  int packet_size = 8900;  // bytes, all headers
  double rate_hz = kRate;
  int queue_frame_sets = 50;
  int lead_periods = 4;
};

// Programs and files, no network.
class HouseTest : public testing::Test {
 protected:
  HouseTest();
  ~HouseTest() override;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path takes() const { return folder_ / "takes"; }
  // rotunda with --takes of this test's folder and its daemon's socket.
  Outcome rotunda(std::vector<std::string> arguments);
  std::unique_ptr<ScopedProgram> start(const std::string& program, std::vector<std::string> arguments);
  Outcome run(const std::string& program, std::vector<std::string> arguments);

  std::filesystem::path socket() const { return folder_ / "rotunda.sock"; }

 private:
  std::filesystem::path folder_;
  int programs_ = 0;  // numbers their logs
};

// And a loopback of their own with cameras on it.
class StudioTest : public HouseTest {
 protected:
  void SetUp() override;

  // Writes NAME.yaml and its calibration; the cameras are cam00... on 127.0.0.1...
  std::filesystem::path write_rig(const SmallRig& rig = {}, const std::string& name = "rig");
  std::unique_ptr<ScopedProgram> start_sim(const std::filesystem::path& rig);  // returns when its cameras answer
  // Without live surfaces, which cost sanitized programs dear, unless `more` asks for them: "--surfaces".
  std::unique_ptr<ScopedProgram> start_daemon(const std::filesystem::path& rig, std::vector<std::string> more = {});
  nlohmann::json status();
  // Asks for the status until it is as wanted; fails the test if that never comes.
  nlohmann::json wait_for_status(const std::function<bool(const nlohmann::json&)>& wanted);
  nlohmann::json verify(const std::string& take, int exit_code);
};

// Every file below a folder and what is in it: to see that nothing there has changed.
std::map<std::string, std::string> contents_of(const std::filesystem::path& folder);

// The state of every camera in a status, "streaming streaming lost".
std::string camera_states(const nlohmann::json& status);

}  // namespace rotunda::tests
