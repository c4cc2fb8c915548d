// What an operator has: the page in a real terminal (tmux), which camera is which, the written rig file, the preflight.
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "config/rig_config.h"
#include "simulator/gige/control_socket.h"
#include "simulator/gige/fault_control.h"
#include "tests/integration/house_test.h"
#include "tests/support/gige_test_studio.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kTmux = "/usr/bin/tmux";
constexpr std::size_t kCameras = 3;
constexpr double kPageRate = 10.0;

// A terminal that a program believes in: its screen can be read, its keys pressed, its size changed.
class TmuxTerminal {
 public:
  TmuxTerminal(const fs::path& folder, int columns, int rows, const std::string& command)
      : folder_(folder), socket_((folder / "tmux.sock").string()) {
    tmux({"-f", "/dev/null", "new-session", "-d", "-s", "t", "-x", std::to_string(columns), "-y", std::to_string(rows),
          command + "; echo left with $?; exec sh"});
  }
  ~TmuxTerminal() { tmux({"kill-server"}); }
  TmuxTerminal(const TmuxTerminal&) = delete;
  TmuxTerminal& operator=(const TmuxTerminal&) = delete;

  void press(const std::string& keys) { tmux({"send-keys", "-t", "t", "-l", keys}); }
  void press_named(const std::string& key) { tmux({"send-keys", "-t", "t", key}); }
  void resize(int columns, int rows) {
    tmux({"resize-window", "-t", "t", "-x", std::to_string(columns), "-y", std::to_string(rows)});
  }
  std::string screen() { return tmux({"capture-pane", "-p", "-t", "t"}); }
  std::string screen_with_colours() { return tmux({"capture-pane", "-p", "-e", "-t", "t"}); }
  // Until it shows `text`, and how long that took; fails the test if it never does.
  std::chrono::steady_clock::duration wait_for(const std::string& text, bool there = true) {
    const auto begun = std::chrono::steady_clock::now();
    while ((screen().find(text) != std::string::npos) != there) {
      if (std::chrono::steady_clock::now() - begun > kPatience || testing::Test::HasFailure()) {
        ADD_FAILURE() << (there ? "never shows: " : "still shows: ") << text << "\n" << screen();
        break;
      }
      std::this_thread::sleep_for(20ms);
    }
    return std::chrono::steady_clock::now() - begun;
  }

 private:
  std::string tmux(std::vector<std::string> arguments) {
    const std::vector<std::string> server{kTmux, "-S", socket_};
    arguments.insert(arguments.begin(), server.begin(), server.end());
    return run_program(arguments, folder_ / "tmux").out;
  }

  fs::path folder_;
  std::string socket_;
};

std::string line_with(const std::string& screen, const std::string& word) {
  std::istringstream lines(screen);
  for (std::string line; std::getline(lines, line);)
    if (line.find(word) != std::string::npos) return line;
  return "";
}

class Operator : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    if (IsSkipped()) return;
    // Where the system allows it, for cameras, daemon and page alike: how soon a loss is shown is asked here.
    const sched_param before_others{.sched_priority = 1};
    sched_setscheduler(0, SCHED_RR, &before_others);
    studio_.emplace(TestStudioOptions{.cameras = kCameras, .width = kWidth, .height = kHeight});
    control_.emplace(simulator::FaultControlOptions{.script = {}, .socket = folder() / "sim.sock"},
                     std::vector<std::string>{"cam00", "cam01", "cam02"});
    control_->start(**studio_);
  }
  void TearDown() override {
    control_.reset();
    studio_.reset();
  }

  std::unique_ptr<ScopedProgram> start_rig() {
    rig_ = write_rig({.cameras = kCameras, .rate_hz = kPageRate});
    return start_daemon(rig_);
  }
  std::unique_ptr<TmuxTerminal> open_page(int columns = 80, int rows = 24) {
    if (!fs::exists(kTmux)) return nullptr;
    return std::make_unique<TmuxTerminal>(folder(), columns, rows,
                                          fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {}/rotunda --daemon {} tui",
                                                      ROTUNDA_BINARY_DIR, socket().string()));
  }
  void ask_studio(const std::string& request) {
    const auto answer = simulator::ask_control_socket(folder() / "sim.sock", request);
    EXPECT_EQ(json::parse(answer)["ok"], true) << answer;
  }

  fs::path rig_;
  std::optional<TestStudio> studio_;
  std::optional<simulator::FaultControl> control_;
};

TEST_F(Operator, RecordsMarksNotesAndStopsByKeysAndAQuitPageStopsNothing) {
  const auto daemon = start_rig();
  const auto page = open_page();
  ASSERT_TRUE(page) << "no tmux to open a terminal with; scripts/install-packages brings it";
  page->wait_for("ARMED");
  for (const auto* camera : {"cam00", "cam01", "cam02"}) EXPECT_THAT(page->screen(), HasSubstr(camera));

  page->press("l");
  page->wait_for("scene: ");
  page->press("12");
  page->press_named("Enter");
  page->press("B");
  page->press_named("Enter");
  page->wait_for("scene 12 shot B");
  page->press("r");
  page->wait_for("RECORDING");
  page->wait_for("take 12B-01");
  page->press("m");
  page->wait_for("1 mark");
  page->press("n");
  page->press("qs first");  // no commands while a line is typed
  page->press_named("Enter");
  page->wait_for("note: qs first");
  page->press("c");
  page->wait_for("(*)");
  page->press("q");
  page->wait_for("take 12B-01 is still recording");
  page->wait_for("left with 0");

  const auto before = status();
  EXPECT_EQ(before["state"], "recording");
  const auto later = wait_for_status(
      [&](const json& now) { return now["take"]["frame_sets"] > before["take"]["frame_sets"].get<int>() + 3; });
  EXPECT_EQ(later["take"]["name"], "12B-01");

  page->press(fmt::format("{}/rotunda --daemon {} tui; echo left again $?\n", ROTUNDA_BINARY_DIR, socket().string()));
  page->wait_for("RECORDING");
  page->press("s");
  page->wait_for("is closed");
  page->press("t");
  page->wait_for("TAKES 1");
  page->wait_for("12B-01");
  page->press_named("Enter");
  page->wait_for("not reconstructed yet: rotunda recon 12B-01");
  page->press("t");
  page->press("q");
  page->wait_for("left again 0");

  const auto shown = json::parse(rotunda({"take", "show", "12B-01", "--json"}).out);
  EXPECT_EQ(shown["state"], "complete");
  EXPECT_EQ(shown["scene"], "12");
  EXPECT_EQ(shown["note"], "qs first");
  EXPECT_EQ(shown["circled"], true);
  EXPECT_EQ(shown["complete"], shown["frame_sets"]);
}

TEST_F(Operator, SeesALostCameraInRedWithinASecond) {
  const auto daemon = start_rig();
  const auto page = open_page();
  ASSERT_TRUE(page) << "no tmux to open a terminal with; scripts/install-packages brings it";
  page->wait_for("ARMED");
  page->press("a");
  page->wait_for("LIVE");
  wait_for_status([](const json& now) {
    return std::all_of(now["cameras"].begin(), now["cameras"].end(),
                       [](const json& camera) { return camera["rate_hz"] > 0.8 * kPageRate; });
  });
  std::this_thread::sleep_for(1500ms);  // of quiet: the control run
  EXPECT_THAT(page->screen(), Not(HasSubstr(" lost ")));

  ask_studio("cam01: { silence: 60s }");
  EXPECT_LT(page->wait_for(" lost "), 3s) << "a second, and what a busy machine takes for it";
  // A busy machine holds up another camera's frames for a moment; that passes.
  const auto only_it_is_red = [&] {
    const auto screen = page->screen_with_colours();
    const auto lost = line_with(screen, "cam01 ");
    return lost.find("lost") != lost.npos && lost.find("41m") != lost.npos &&
           line_with(screen, "cam00 ").find("41m") == std::string::npos;
  };
  bool seen = false;
  for (int i = 0; i < 100 && !seen; ++i, std::this_thread::sleep_for(100ms)) seen = only_it_is_red();
  EXPECT_TRUE(seen) << page->screen_with_colours();
  EXPECT_THAT(page->screen(), HasSubstr("check its cable and power"));
  EXPECT_GT(studio_->stats()[1].faults[simulator::FaultKind::silence], 0U);
}

TEST_F(Operator, IsToldInWordsWhenTheDaemonIsSilentOrGoneAndSeesItComeBack) {
  auto daemon = start_rig();
  const auto page = open_page();
  ASSERT_TRUE(page) << "no tmux to open a terminal with; scripts/install-packages brings it";
  page->wait_for("ARMED");
  daemon->send(SIGSTOP);
  page->wait_for("the daemon has not answered for");
  page->press("?");  // and the screen is not frozen
  page->wait_for("It never stops a recording");
  page->press("?");
  daemon->send(SIGCONT);
  page->wait_for("has not answered", false);

  daemon->send(SIGKILL);
  daemon->wait();
  page->wait_for("NO DAEMON");
  page->wait_for("no daemon answers on");
  daemon = start_daemon(rig_);
  page->wait_for("ARMED");
  page->wait_for("NO DAEMON", false);
}

TEST_F(Operator, ResizesAndLeavesTheTerminalAsItWasWhateverEndsIt) {
  const auto daemon = start_rig();
  const auto page = open_page();
  ASSERT_TRUE(page) << "no tmux to open a terminal with; scripts/install-packages brings it";
  page->wait_for("ARMED");
  EXPECT_THAT(page->screen(), Not(HasSubstr("resends")));
  page->resize(160, 50);
  page->wait_for("resends");
  page->resize(80, 24);
  page->wait_for("resends", false);
  const auto restored = [&](const std::string& word) {
    page->wait_for(word);
    EXPECT_THAT(page->screen(), Not(HasSubstr("ARMED"))) << "the page is still there";
    page->press("stty -a | grep -o ' echo ' | tr -d ' ' | sed s/^/terminal_/\n");
    page->wait_for("terminal_echo");
    page->press("clear\n");
    page->wait_for("terminal_echo", false);
  };
  page->press("q");
  restored("left with 0");
  const auto pid_file = folder() / "page.pid";
  const auto again = fmt::format("sh -c 'echo $$ > {}; exec {}/rotunda --daemon {} tui'; echo ended by $?\n",
                                 pid_file.string(), ROTUNDA_BINARY_DIR, socket().string());
  for (const int signal : {SIGTERM, SIGQUIT}) {
    page->press(again);
    page->wait_for("ARMED");
    kill(std::stoi(text_of(pid_file)), signal);
    restored(fmt::format("ended by {}", signal == SIGTERM ? 0 : 128 + signal));
  }
}

TEST_F(Operator, WithoutATerminalIsRefusedPolitely) {
  const auto outcome = rotunda({"tui"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("needs a terminal"), HasSubstr("rotunda status")));
  EXPECT_EQ(outcome.out, "");
}

TEST_F(Operator, GetsACommentedRigFileThatTheDaemonTakes) {
  const auto file = folder() / "found.yaml";
  const auto outcome = rotunda({"rig", "init", "-o", file.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rig = config::load_rig(file);
  ASSERT_EQ(rig.cameras.size(), kCameras);
  for (std::size_t i = 0; i < kCameras; ++i) {
    EXPECT_EQ(rig.cameras[i].name, fmt::format("cam{:02}", i)) << "its user name";
    EXPECT_EQ(rig.cameras[i].device, fmt::format("RS{:04}", i));
  }
  EXPECT_EQ(rig.trigger.interface_address, "127.0.0.1");
  const auto text = text_of(file);
  for (const auto* word : {"rate_hz", "Microseconds", "127.0.0.2", "reserve_mb", "# calibration"})
    EXPECT_THAT(text, HasSubstr(word));
  const auto again = rotunda({"rig", "init", "-o", file.string()});
  EXPECT_EQ(again.exit_code, 3);
  EXPECT_EQ(text_of(file), text);
  const auto check = run("rotundad", {"--rig", file.string(), "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, AllOf(HasSubstr("good, 3 cameras"), HasSubstr("calibration"), HasSubstr("disk speed")));
}

TEST_F(Operator, SeesWhichCameraIsWhichWithAndWithoutADaemon) {
  const auto sheet = folder() / "cameras.png";
  const auto alone = rotunda({"cameras", "identify", "--json", "-o", sheet.string()});
  ASSERT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  const auto told = json::parse(alone.out)["cameras"];
  ASSERT_EQ(told.size(), kCameras);
  for (const auto& camera : told) EXPECT_TRUE(camera["pictured"] && camera["blinked"]) << camera.dump();
  EXPECT_FALSE(cv::imread(sheet.string()).empty());
  fs::remove(sheet);

  const auto daemon = start_rig();
  const auto one = rotunda({"cameras", "identify", "cam02", "--json", "-o", sheet.string()});
  ASSERT_EQ(one.exit_code, 0) << one.out << one.err;
  const auto camera = json::parse(one.out)["cameras"].at(0);
  EXPECT_EQ(camera["serial"], "RS0002");
  EXPECT_EQ(camera["address"], "127.0.0.3");
  EXPECT_EQ(camera["blinked"], true);
  EXPECT_FALSE(cv::imread(sheet.string()).empty());
  EXPECT_EQ(status()["state"], "armed") << "it was live for a moment only";
  const auto unknown = rotunda({"cameras", "identify", "cam77", "-o", sheet.string()});
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("no camera cam77"), HasSubstr("cam00")));
}

TEST_F(Operator, IsToldWhyNothingCanBeRecorded) {
  const auto rig = write_rig({.cameras = kCameras, .reserve_mb = 1e9});
  const auto daemon = start_daemon(rig);
  const auto now = wait_for_status([](const json& answer) { return !answer["cannot_record"].empty(); });
  EXPECT_THAT(now["cannot_record"][0].get<std::string>(), HasSubstr("storage.reserve_mb keeps 1000000000"));
  EXPECT_THAT(rotunda({"status"}).out, HasSubstr("cannot record: disk of "));
  const auto doctor = rotunda({"doctor", "--json", "--rig", rig.string()});
  EXPECT_EQ(doctor.exit_code, 1);
  EXPECT_FALSE(json::parse(doctor.out)["cannot_record"].empty()) << doctor.out;
}

}  // namespace
}  // namespace rotunda::tests
