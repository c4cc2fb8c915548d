// kill -9 of the daemon, again and again, while a take is begun, recorded and closed: what was written is there, bit
// for bit, and the next daemon records on. ROTUNDA_KILLS=100 does it a hundred times and holds the daemon's return
// against its promise of a second; ROTUNDA_SEED=N chooses other moments.
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <random>
#include <thread>

#include "capture/take/take_reader.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using std::chrono::steady_clock;
using testing::HasSubstr;

constexpr std::size_t kCameras = 3;
constexpr int kFrameSets = 30;  // of each take, at 25 Hz
constexpr std::uintmax_t kPixels = kWidth * kHeight;

int number_from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::max(1, std::atoi(text)) : otherwise;
}

// What one camera's file has after a kill.
struct Remains {
  std::size_t frames = 0;
  std::uintmax_t cut = 0;  // bytes behind the last whole frame, about
};

class DaemonKill : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    studio_.emplace(TestStudioOptions{.cameras = kCameras, .width = kWidth, .height = kHeight});
    rig_ = write_rig({.cameras = kCameras, .rate_hz = 25.0});
  }

  // Starts a daemon; how long until it answers.
  steady_clock::duration bring_up() {
    const auto began = steady_clock::now();
    daemon_ = start_daemon(rig_);
    return steady_clock::now() - began;
  }
  void wait_for_cameras() {
    wait_for_status([](const auto& now) { return camera_states(now) == "streaming streaming streaming"; });
  }

  // From the moment the take's folder is there: a fifth of the kills hit its making, a fifth its end.
  std::chrono::microseconds moment(int kill) {
    const auto between = [&](std::chrono::microseconds from, std::chrono::microseconds to) {
      return std::chrono::microseconds(std::uniform_int_distribution<long>(from.count(), to.count())(random_));
    };
    if (kill % 5 == 1) return between(0us, 20ms);
    if (kill % 5 == 3) return between(1200ms, 1500ms);
    return between(0us, 1400ms);
  }

  void record_until_killed(const std::string& name, std::chrono::microseconds after) {
    const auto take = start("rotunda", {"--takes", takes().string(), "--daemon", socket().string(), "take", "start",
                                        name, "--frames", std::to_string(kFrameSets)});
    const auto give_up = steady_clock::now() + kPatience;
    while (!fs::exists(takes() / name) && steady_clock::now() < give_up) std::this_thread::sleep_for(200us);
    std::this_thread::sleep_for(after);
    daemon_->send(SIGKILL);
    EXPECT_EQ(daemon_->wait(), 128 + SIGKILL);
    take->wait();
  }

  Remains remains_of(const capture::TakeReader& take, std::size_t camera) const {
    Remains remains;
    for (std::size_t set = 0; set < take.frame_set_count(); ++set) {
      const auto slot = take.read(set, camera);
      if (!slot.frame) continue;
      ++remains.frames;
      const auto seen = studio_->picture(camera, slot.frame->exposure_start);
      const auto kept = slot.frame->image.bytes();
      EXPECT_TRUE(std::equal(kept.begin(), kept.end(), seen.begin(), seen.end())) << "frame set " << set;
    }
    const auto file = capture::camera_file(take.folder(), take.info().cameras[camera].name);
    const auto size = fs::exists(file) ? fs::file_size(file) : 0;  // the take was still being made
    remains.cut = size - std::min(size, remains.frames * kPixels);
    return remains;
  }

  // A frame's own head and record, and the file's head: far less than a frame.
  static std::uintmax_t besides_pixels(std::size_t frames) { return 4096 + 400 * frames; }

  void expect_all_but_the_record_being_written(const std::string& name) {
    const capture::TakeReader take(takes() / name);
    std::size_t most = 0, fewest = kFrameSets;
    for (std::size_t camera = 0; camera < kCameras; ++camera) {
      SCOPED_TRACE(camera);
      const auto remains = remains_of(take, camera);
      EXPECT_LT(remains.cut, kPixels + besides_pixels(remains.frames)) << "more than a record of it was left out";
      most = std::max(most, remains.frames);
      fewest = std::min(fewest, remains.frames);
    }
    for (const auto& [trigger, cameras] : take.journal().missing) fewest += cameras.size();  // not the kill's doing
    EXPECT_LE(most, fewest + 1) << "cameras are written in turn";
    frames_kept_ += most;
  }

  void expect_recovers(const std::string& name) {
    const auto before = contents_of(takes() / name);
    const auto listed = rotunda({"take", "list"}).out;
    EXPECT_THAT(listed, HasSubstr(name));
    interrupted_ += listed.find("interrupted") != std::string::npos;
    const auto recovered = rotunda({"take", "recover", name});
    EXPECT_LE(recovered.exit_code, 1) << recovered.err;
    auto after = contents_of(takes() / name);
    for (const auto& [file, content] : before) {
      if (file == "take.yaml") continue;
      EXPECT_TRUE(after[file] == content) << file << " was touched";
    }
    EXPECT_LE(rotunda({"take", "verify", name}).exit_code, 1);
    expect_all_but_the_record_being_written(name);
  }

  std::optional<TestStudio> studio_;
  fs::path rig_;
  std::unique_ptr<ScopedProgram> daemon_;
  std::mt19937 random_;
  std::size_t interrupted_ = 0, frames_kept_ = 0;
};

TEST_F(DaemonKill, AtRandomMomentsCostsAtMostTheRecordBeingWrittenAndTheNextDaemonRecordsOn) {
  const int kills = number_from_environment("ROTUNDA_KILLS", 5);
  const int seed = number_from_environment("ROTUNDA_SEED", 1);
  random_.seed(static_cast<unsigned>(seed));
  bring_up();
  std::vector<double> seconds;
  for (int kill = 0; kill < kills && !HasFailure(); ++kill) {
    SCOPED_TRACE(fmt::format("kill {} of seed {}", kill, seed));
    wait_for_cameras();
    const auto name = fmt::format("cut{:03}", kill);
    record_until_killed(name, moment(kill));
    seconds.push_back(std::chrono::duration<double>(bring_up()).count());
    expect_recovers(name);
    fs::remove_all(takes() / name);
  }
  std::sort(seconds.begin(), seconds.end());
  std::cout << fmt::format(
      "{} kills: {} takes interrupted, {} frame sets kept; the daemon answers again after {:.2f} s "
      "(median), {:.2f} s (longest)\n",
      kills, interrupted_, frames_kept_, seconds[seconds.size() / 2], seconds.back());
  EXPECT_GE(interrupted_, static_cast<std::size_t>(kills / 2)) << "most come while a take is written";
  EXPECT_GT(frames_kept_, 0U);
  if (std::getenv("ROTUNDA_KILLS")) {
    EXPECT_LE(seconds.back(), 1.0);
  }
  wait_for_cameras();
  EXPECT_EQ(rotunda({"take", "start", "after", "--frames", "5"}).exit_code, 0);
  EXPECT_EQ(verify("after", 0)["complete"], 5);
}

}  // namespace
}  // namespace rotunda::tests
